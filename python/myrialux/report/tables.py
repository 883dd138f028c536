"""HTML tables of numbers and of texts."""
import html
import math


def number(value, unit=""):
    """Three digits and the unit; "%" tells a share times 100. None and NaN: a dash."""
    if value is None or math.isnan(value):
        return "–"
    if isinstance(value, int):
        return str(value)
    if unit == "%":
        return three_digits(100 * value) + " %"
    return f"{value:.2f} {unit}" if unit == "dB" else f"{three_digits(value)} {unit}".rstrip()


def three_digits(value):
    """Also where the last ones are 0."""
    return f"{value:#.3g}".removesuffix(".")


def table(columns, rows, best=()):
    """Numbers with their pictures' names in front.

    columns: (title, what it means). rows: texts, the name first. best: (row, column) of cells to set in bold, counted
    from 0 without the name.
    """
    head = "".join(f'<th title="{html.escape(meaning)}">{html.escape(title)}</th>' if meaning else
                   f"<th>{html.escape(title)}</th>" for title, meaning in columns)
    body = ""
    for r, row in enumerate(rows):
        cells = "".join(f'<td{" class=best" if (r, c - 1) in best else ""}>{html.escape(text)}</td>'
                        for c, text in enumerate(row))
        body += f"<tr>{cells}</tr>\n"
    return f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>'


def best_cells(values, smaller_is_better):
    """(row, column) of the best value of each column, also where several are best; none where a column is alike.

    values: rows of numbers or None. smaller_is_better: one bool a column; None: nothing is best.
    """
    cells = set()
    for c, smaller in enumerate(smaller_is_better):
        column = [(row[c], r) for r, row in enumerate(values) if row[c] is not None]
        if smaller is None or len({v for v, _ in column}) < 2:
            continue
        best = (min if smaller else max)(v for v, _ in column)
        cells |= {(r, c) for v, r in column if v == best}
    return cells


def text_table(columns, rows, differing=()):
    """Texts, which may be long. columns: titles. rows: (key, text of each further column). differing: keys to mark."""
    head = "".join(f"<th>{html.escape(title)}</th>" for title in columns)
    body = "".join(f'<tr{" class=differs" if key in differing else ""}><td>{html.escape(key)}</td>'
                   + "".join(f"<td class=text>{html.escape(text)}</td>" for text in texts) + "</tr>\n"
                   for key, *texts in rows)
    return f'<div class="wide"><table class="texts">\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>'


def definitions(pairs):
    """A list of (term, meaning)."""
    return "<dl>" + "".join(f"<dt>{html.escape(t)}</dt><dd>{html.escape(m)}</dd>\n" for t, m in pairs) + "</dl>"
