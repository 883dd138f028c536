"""One HTML page in one file: style, scripts, plotly.js, figures and pictures are all inside."""
import html
import json
import pathlib

from plotly.offline import get_plotlyjs

_HERE = pathlib.Path(__file__).parent
# By default plotly.js offers a button that uploads the figure to its maker.
_CONFIG = {"responsive": True, "displaylogo": False, "scrollZoom": True, "showSendToCloud": False}
# The browser itself refuses whatever is not in the file.
_POLICY = ("default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
           "font-src data:")


class Page:
    """Collects parts from top to bottom. Text is escaped; what is called html is not."""

    def __init__(self, title, subtitle=""):
        self.title = title
        self._parts = [f"<h1>{html.escape(title)}</h1>"]
        if subtitle:
            self._parts.append(f'<p class="subtitle">{html.escape(subtitle)}</p>')
        self._pictures = {}
        self._n_figures = 0

    def heading(self, text, level=2):
        self._parts.append(f"<h{level}>{html.escape(text)}</h{level}>")

    def paragraph(self, text):
        self._parts.append(f"<p>{html.escape(text)}</p>")

    def html(self, part):
        self._parts.append(part)

    def figure(self, figure):
        """A Plotly figure; its id counts up, so that the same page is the same bytes."""
        self._n_figures += 1
        self._parts.append(figure.to_html(full_html=False, include_plotlyjs=False, div_id=f"figure-{self._n_figures}",
                                          config=_CONFIG))

    def picture(self, name, data_url):
        """Makes a picture known to sliders under its name."""
        self._pictures[name] = data_url

    def slider(self, left, right, width, height):
        """Two known pictures on top of each other with a line to drag; the reader may choose others of them."""
        def choice(side, chosen):
            options = "".join(f"<option{' selected' if name == chosen else ''}>{html.escape(name)}</option>"
                              for name in self._pictures)
            return f'<label>{side} <select data-side="{side}">{options}</select></label>'

        zooms = "".join(f'<option value="{z}">{text}</option>'
                        for z, text in [("", "fit"), (1, "1x"), (2, "2x"), (4, "4x"), (8, "8x")])
        self._parts.append(
            f'<figure class="slider" style="--w:{width};--h:{height}"><figcaption>{choice("left", left)}'
            f'{choice("right", right)}<label>zoom <select data-zoom>{zooms}</select></label></figcaption>'
            '<div class="scroll"><div class="stage"><img data-side="right" alt=""><img data-side="left" alt="">'
            '<input type="range" min="0" max="100" step="0.1" value="50" aria-label="where the pictures meet">'
            "</div></div></figure>")

    def text(self):
        style, script = (_HERE / "page.css").read_text(), (_HERE / "page.js").read_text()
        # "<" is escaped so that no name of a picture can end the script.
        pictures = json.dumps(self._pictures).replace("<", "\\u003c")
        return "\n".join([
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{html.escape(self.title)}</title>\n<style>\n{style}</style>",
            f'<script id="plotly">{get_plotlyjs()}</script>\n</head>\n<body>\n<main>', *self._parts,
            f"</main>\n<script>const pictures = {pictures};\n{script}</script>\n</body>\n</html>\n"])

    def write(self, path):
        pathlib.Path(path).write_text(self.text(), encoding="utf-8")
