"""How Sphinx builds the documentation site from docs/: `make docs`."""

import re
import sys
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT))

from tools.site.pages import write_pages  # noqa: E402

project, author = "Tumble", "the Tumble authors"
copyright = author
release = version = installed("tumble")
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = ["**/.*"]

# Pages
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "pydata_sphinx_theme"
html_title = "Tumble"
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_sidebars = {page: [] for page in ("index", "generated/api", "generated/commands", "generated/tables")}
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": False,
    "show_toc_level": 2,
    "header_links_before_dropdown": 6,
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button-field"],
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["sphinx-version"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

# Notebooks: executed anew at every build, and never with a script from the network.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_ipywidgets_js: dict[str, Any] = {}

# The API
nitpicky = True
# Offline there is no inventory of other projects' names; ours must all be found.
nitpick_ignore_regex = [
    (r"py:.*", r"(?!tumble\.).*"),
    (r"py:.*", r"tumble\.(compare|scenarios|solver|reports|api)\..*"),
]
autodoc_typehints = "none"  # the meanings name what is taken; the annotations are long unions
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False

OUTSIDE = re.compile(r"\[([^\]]+)\]\((?:\.\./)+[^)]*\)")  # a link to the program's text, which is no page


def setup(app: Sphinx) -> None:
    """Make the generated pages before the build, and fit the pages of docs/ to the site."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir) / "generated"))
    app.connect("source-read", without_links_outside)
    app.connect("html-page-context", without_empty_headers)
    app.connect("autodoc-process-docstring", meanings_below_names, priority=400)  # before napoleon


def without_links_outside(app: Sphinx, page: str, source: list[str]) -> None:
    """Make plain text of links to files that are not part of the site."""
    source[0] = OUTSIDE.sub(r"\1", source[0])


def without_empty_headers(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Make plain cells of the empty corner of a pandas table: a header without text says nothing to a screen reader."""
    if "body" in context:
        context["body"] = context["body"].replace("<th></th>", "<td></td>")


def meanings_below_names(app: Sphinx, what: str, name: str, found: Any, options: Any, lines: list[str]) -> None:
    """Put the meaning of `name : meaning`, which is this project's form, where numpy's form has it: below the name."""
    section = ""
    made: list[str] = []
    for line, after in zip(lines, [*lines[1:], ""], strict=True):
        section = line if after and not after.strip("-") else section
        entry = re.match(r"(\*{0,2}\w+) : (.+)", line) if section == "Parameters" else None
        made += [entry[1], f"    {entry[2]}"] if entry else [line]
    lines[:] = made
