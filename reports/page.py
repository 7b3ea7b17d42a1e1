"""The report: one self-contained page, made from the tables and nothing else, that sends no request."""

import base64
import hashlib
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from tumble.reports.embedding import data_of
from tumble.reports.modules import page_scripts

TEMPLATES = Path(__file__).parent / "templates"


def page(tables: Mapping[str, pd.DataFrame]) -> str:
    """Return the report as HTML that needs no network; its policy admits only its own scripts and style.

    Parameters
    ----------
    tables
        File name -> table, as `tumble.compare.tables.frames.read_tables` returns them.

    Returns
    -------
    str
        The whole page; it opens from a file.
    """
    style = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    scripts = page_scripts()
    return (
        Environment(loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined)
        .get_template("page.html")
        .render(
            style=Markup(style),
            style_hash=digest(style),
            scripts=[Markup(script) for script in scripts],
            script_hashes=[digest(script) for script in scripts],
            data=Markup(data_of(tables)),
            files=[name for name, table in tables.items() if len(table)],
        )
    )


def digest(text: str) -> str:
    """Return the source expression by which a Content-Security-Policy admits this text."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
