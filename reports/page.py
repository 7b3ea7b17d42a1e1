"""The report: one self-contained page, made from the tables alone, that needs no network."""

import base64
import hashlib
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from tumble.reports.embedding import data_of

TEMPLATES = Path(__file__).parent / "templates"
# The parts of the script, each after those it needs.
SCRIPTS = (
    "data",
    "numbers",
    "dom",
    "state",
    "field",
    "save",
    "table",
    "film",
    "stage",
    "svgpen",
    "chart",
    "player",
    "polhode",
    "board",
    "special",
    "scenes",
    "precision",
    "cost",
    "stable",
    "extremes",
    "agreement",
    "handcalc",
    "spared",
    "releases",
    "provenance",
    "changes",
    "main",
)


def page(tables: Mapping[str, pd.DataFrame]) -> str:
    """Return the report as HTML that needs no network; its policy lets only its own script and style in.

    tables: file name -> table, as tumble.compare.tables.frames.read_tables gives them.
    """
    style = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    script = whole_script()
    return (
        Environment(loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined)
        .get_template("page.html")
        .render(
            style=Markup(style),
            style_hash=digest(style),
            script=Markup(script),
            script_hash=digest(script),
            data=Markup(data_of(tables)),
            files=[name for name, table in tables.items() if len(table)],
        )
    )


def whole_script() -> str:
    """Return the parts of the script as one, with names of its own."""
    parts = [(TEMPLATES / "js" / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS]
    return "\n".join(['(() => {\n"use strict";', *parts, "})();\n"])


def digest(text: str) -> str:
    """Return the hash by which a Content-Security-Policy allows this text."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
