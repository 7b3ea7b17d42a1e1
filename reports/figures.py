"""One figure of a command's tables as SVG or PNG, by Altair and vl-convert, which are the extra `figures`."""

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tumble.compare.run.contestant import Contestant
from tumble.compare.tables.files import write_whole
from tumble.scenarios.refusal import UserError

if TYPE_CHECKING:
    import altair

LIBRARIES = ("altair", "vl_convert")
PNG_SCALE = 2.0
WIDTH = 560
PADDING = {"left": 5, "top": 5, "bottom": 5}  # [px], Vega's own


class NoFigures(UserError):
    """The libraries that draw figures are missing; the message is the one line for the user."""


def check_figures(*files: str | None) -> None:
    """Check that figures can be drawn, before anything is run.

    Parameters
    ----------
    *files : file of each figure; None or empty: this figure is not asked for

    Raises
    ------
    NoFigures : a figure is asked for, and a library that draws it is not installed
    """
    missing = [name.replace("_", "-") for name in LIBRARIES if find_spec(name) is None]
    if any(files) and missing:
        raise NoFigures(f"--svg and --png need {' and '.join(missing)}: in Tumble's checkout, pip install '.[figures]'")


def save_figures(svg: str | None, png: str | None, figure: Callable[[pd.DataFrame], Any], table: pd.DataFrame) -> None:
    """Save the figure of a table as SVG, PNG, both or neither.

    Parameters
    ----------
    svg : SVG file to write; None or empty: none
    png : PNG file to write; None or empty: none
    figure : draws the table, for example `cost_figure`
    table : table that the figure shows

    Raises
    ------
    OSError : a file cannot be written
    """
    if not (svg or png):
        return
    import vl_convert

    spec = figure(table).to_json()
    if svg:
        write_whole(Path(svg), vl_convert.vegalite_to_svg(spec))
    if png:
        write_whole(Path(png), vl_convert.vegalite_to_png(spec, scale=PNG_SCALE))


def figure_of(tables: Mapping[str, pd.DataFrame]) -> "altair.TopLevelMixin":
    """Return the figure of a command's tables.

    Parameters
    ----------
    tables : table by file name

    Returns
    -------
    error against run time, the largest stable step, or the error of each contestant, by what the tables hold

    Raises
    ------
    NoFigures : Altair is not installed, or the tables have no figure
    """
    if find_spec("altair") is None:
        raise NoFigures("plot() needs altair: install the extra `figures`, pip install 'tumble[figures]'")
    figures = {"work-precision.csv": cost_figure, "limits.csv": limit_figure, "runs.csv": error_figure}
    for name, draw in figures.items():
        if name in tables and len(tables[name]):
            return draw(tables[name])
    raise NoFigures(f"no figure: plot() draws {', '.join(figures)}, and none of them is here")


def error_figure(runs: pd.DataFrame) -> "altair.TopLevelMixin":
    """Return each contestant's largest error.

    Parameters
    ----------
    runs : table as in runs.csv

    Returns
    -------
    the figure, one panel for each scene
    """
    import altair

    shown = named(runs.loc[finite(runs, "max_error_m")])
    shown = shown.assign(shown_m=shown[["max_error_m", "resolution_m"]].max(axis=1))
    chart = altair.Chart(records(shown)).encode(
        y=altair.Y("contestant:N", sort=altair.EncodingSortField("shown_m", op="min"), title=None),
        x=altair.X("shown_m:Q", scale=altair.Scale(type="log"), title="largest vertex error [m]", axis=powers()),
        color=altair.Color("engine:N", title=None),
        shape=altair.Shape("status:N", title=None),
    )
    points = chart.mark_point(filled=True, size=70)
    return points.properties(width=WIDTH).facet(row=altair.Row("scene:N", title=None)).resolve_scale(y="independent")


def cost_figure(measured: pd.DataFrame) -> "altair.TopLevelMixin":
    """Return error against time of every run, one line for each contestant.

    Parameters
    ----------
    measured : table as in work-precision.csv

    Returns
    -------
    the figure, one panel for each scene
    """
    import altair

    shown = named(measured.loc[finite(measured, "error_m") & (measured["status"] == "ok").to_numpy()])
    chart = altair.Chart(records(shown)).encode(
        x=altair.X("run_us:Q", scale=altair.Scale(type="log"), title="run time [us]", axis=powers()),
        y=altair.Y("error_m:Q", scale=altair.Scale(type="log"), title="largest vertex error [m]", axis=powers()),
        color=altair.Color("engine:N", title=None),
        detail="contestant:N",
        shape=altair.Shape("contestant:N", title=None, legend=altair.Legend(symbolLimit=0)),
        order="run_us:Q",
    )
    drawn = (chart.mark_line(strokeWidth=1) + chart.mark_point(filled=True, size=40)).properties(
        width=WIDTH, height=380
    )
    # Room beside the legend: where a font is wider than the one that was measured, its labels are not cut.
    return drawn.facet(row=altair.Row("scene:N", title=None)).properties(padding={**PADDING, "right": 40})


def limit_figure(limits: pd.DataFrame) -> "altair.TopLevelMixin":
    """Return the largest stable step of each contestant, with the predicted one as a line.

    Parameters
    ----------
    limits : table as in limits.csv

    Returns
    -------
    the figure, one panel for each scene
    """
    import altair

    shown = named(limits.loc[finite(limits, "w_dt_limit") & (limits["w_dt_limit"] > 0).to_numpy()])
    chart = altair.Chart(records(shown)).encode(
        y=altair.Y("contestant:N", sort=altair.EncodingSortField("w_dt_limit", order="descending"), title=None),
        color=altair.Color("beyond:N", title="behaviour beyond it"),
    )
    scale = altair.Scale(type="log")
    measured = chart.mark_point(filled=True, size=70).encode(
        x=altair.X("w_dt_limit:Q", scale=scale, title="largest stable step, w dt [rad]; line: theory")
    )
    theory = chart.mark_tick(thickness=2, size=16, color="black").encode(x=altair.X("theory_w_dt:Q", scale=scale))
    drawn = (measured + theory).properties(width=WIDTH)
    return drawn.facet(row=altair.Row("scene:N", title=None)).resolve_scale(y="independent")


def named(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with a column ENGINE:METHOD, the tolerances of an adaptive method together."""
    return table.assign(
        contestant=[
            str(Contestant.of(engine, method).without_tolerance)
            for engine, method in zip(table["engine"], table["method"], strict=True)
        ]
    )


def finite(table: pd.DataFrame, column: str) -> np.ndarray:
    """Return which cells of a column are finite numbers."""
    return np.isfinite(table[column].to_numpy(dtype=float))


def records(table: pd.DataFrame) -> "altair.Data":
    """Return a table as data of a figure, with null for numbers that JSON has not."""
    import altair

    plain = table.astype(object).where(table.notna(), None).replace([float("inf"), -float("inf")], None)
    return altair.Data(values=plain.to_dict("records"))


def powers() -> "altair.Axis":
    """Return an axis of powers of ten."""
    import altair

    return altair.Axis(format=".0e", tickCount=8)
