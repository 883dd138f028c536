"""Plotly figures of errors: maps, histograms, curves over time or rays."""
import dataclasses
import math

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from myrialux.report.pictures import luminance

COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f6000", "#444444"]
_FONT = {"family": "system-ui, sans-serif", "size": 13, "color": "#222"}


def signed_relative_error(reference, picture, epsilon):
    """(Y_picture - Y_reference) / sqrt(Y_reference^2 + epsilon): its mean square is relMSE of luminance."""
    y = luminance(reference)
    return (luminance(picture) - y) / np.sqrt(y * y + epsilon)


def round_up(value):
    """The next of 1, 2, 5, 10, ... times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-9))


def error_limit(errors, percentile):
    """A round number that this percentage of the pixels of every picture stays below; at least 1 %."""
    largest = max((float(np.percentile(np.abs(e), percentile)) for e in errors), default=0.0)
    return round_up(max(largest, 0.01))


def percent(value):
    """A share as text, three digits."""
    return f"{100 * value:.3g} %"


def error_maps(signed_error, flip_map, limit, origin=(0, 0)):
    """Signed relative error and, where there is one, FLIP, side by side; zooming one zooms the other.

    signed_error: [height, width]; told to 0.1 %. flip_map: [height, width] in 0 to 1 or None. origin: x, y of the
    first pixel, so that the pixels under the mouse are named as in the whole picture.
    """
    height, width = signed_error.shape
    n = 1 if flip_map is None else 2
    titles = ["relative error of luminance: red too bright, blue too dark", "HDR-FLIP: what an eye notices, 0 to 1"]
    figure = make_subplots(1, n, shared_xaxes="all", shared_yaxes="all", horizontal_spacing=0.09,
                           subplot_titles=titles[:n])
    # Small integers instead of floats: a third of the size of the page.
    ticks = np.array([-1, -0.5, 0, 0.5, 1]) * limit
    place = {"x0": origin[0], "y0": origin[1], "dx": 1, "dy": 1}
    bar = {"thickness": 12, "len": 1, "outlinewidth": 0}
    figure.add_trace(go.Heatmap(
        z=np.clip(np.rint(1000 * signed_error), -32767, 32767).astype(np.int16), **place, colorscale="RdBu_r",
        zmin=-1000 * limit, zmax=1000 * limit, name="",
        colorbar={**bar, "x": 0.46 if n == 2 else 1.01, "tickvals": 1000 * ticks, "ticktext": [percent(t) for t in ticks]},
        hovertemplate="pixel %{x},%{y}<br>%{z} per mille"), 1, 1)
    if flip_map is not None:
        figure.add_trace(go.Heatmap(
            z=np.rint(255 * flip_map).astype(np.uint8), **place, colorscale="Magma", zmin=0, zmax=255, name="",
            colorbar={**bar, "x": 1.01, "tickvals": [0, 64, 128, 191, 255], "ticktext": ["0", "0.25", "0.5", "0.75", "1"]},
            hovertemplate="pixel %{x},%{y}<br>%{z} / 255"), 1, 2)
    x, y = origin
    figure.update_xaxes(range=[x - 0.5, x + width - 0.5], constrain="domain", showgrid=False, zeroline=False)
    figure.update_yaxes(range=[y + height - 0.5, y - 0.5], scaleanchor="x", constrain="domain", showgrid=False,
                        zeroline=False)
    map_width = 1200 / n if n == 2 else 1000
    return _styled(figure, height=int(min(map_width * height / width, 700)) + 90)


def error_histogram(errors, limit, n_bins=101):
    """Share of the pixels by signed relative error. errors: name -> array. The outermost bins hold all beyond."""
    edges = np.linspace(-limit, limit, n_bins + 1)
    figure = go.Figure()
    for k, (name, error) in enumerate(errors.items()):
        counts, _ = np.histogram(np.clip(error, -limit, limit), edges)
        shares = np.where(counts > 0, 100 * counts / error.size, np.nan)
        figure.add_trace(go.Scatter(x=50 * (edges[1:] + edges[:-1]), y=shares, name=name, mode="lines",
                                    line={"shape": "hvh", "width": 1.5, "color": COLORS[k % len(COLORS)]},
                                    hovertemplate="%{x:.3g} %: %{y:.3g} % of the pixels"))
    figure.update_xaxes(title="relative error of luminance, % (outermost: all beyond)")
    figure.update_yaxes(title="% of the pixels", type="log", exponentformat="none", dtick=1)
    return _styled(figure, height=320, legend=len(errors) > 1)


@dataclasses.dataclass
class Line:
    """One curve: y over x, both above 0; low and high bound an error bar where known."""
    name: str
    x: list
    y: list
    low: list | None = None
    high: list | None = None
    hover: list | None = None  # text of each point


def lines_log_log(lines, x_title, y_title):
    """Curves on two logarithmic axes, such as error over seconds."""
    figure = go.Figure()
    for k, line in enumerate(lines):
        bars = None
        if line.low is not None and line.high is not None:
            bars = {"type": "data", "symmetric": False, "array": np.subtract(line.high, line.y),
                    "arrayminus": np.subtract(line.y, line.low), "thickness": 1}
        figure.add_trace(go.Scatter(x=line.x, y=line.y, name=line.name, mode="lines+markers", error_y=bars,
                                    text=line.hover, line={"width": 2, "color": COLORS[k % len(COLORS)]}))
    figure.update_xaxes(title=x_title, type="log", exponentformat="power", minor={"showgrid": True})
    figure.update_yaxes(title=y_title, type="log", exponentformat="power", minor={"showgrid": True})
    return _styled(figure, height=460, legend=True)


def _styled(figure, height, legend=False):
    figure.update_layout(template="plotly_white", font=_FONT, height=height, showlegend=legend,
                         margin={"l": 60, "r": 70, "t": 40, "b": 45}, hovermode="closest")
    figure.update_annotations(font_size=14)
    return figure
