"""The page of a scene that needs little, by one contestant: what there is nothing to say of is not on it."""

import re
import subprocess
import sys
from html import unescape

import pytest


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Make the page of a body that never turns, by one contestant, and of one that does, by two."""
    folder = tmp_path_factory.mktemp("pages")
    found = {}
    for name, words in {
        "straight": ("die-straight", "-e", "tumble:rk4"),
        "turning": ("die-vertex", "-e", "tumble:rk4", "-e", "tumble:quaternion-euler"),
    }.items():
        command = [sys.executable, "-P", "-m", "tumble", "report", *words, "-o", f"{name}.html"]
        said = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
        assert said.returncode == 0, said.stderr
        page = (folder / f"{name}.html").read_text(encoding="utf-8")
        # The drawing library and the charts' data are no words of the page.
        found[name] = unescape(re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL))
    return found


@pytest.mark.parametrize(
    "words",
    ["angular momentum", "parts of the error", "attitude", "order <span", 'class="legend"', "frontier", "A ratio"],
)
def test_what_one_body_that_never_turns_has_nothing_for_is_not_there(pages, words):
    assert words not in pages["straight"]
    assert words in pages["turning"], "where there is something to say it is said"


@pytest.mark.parametrize("section", ["table-4-1", "agreement"])
def test_sections_without_anything_to_tell_are_not_there(pages, section):
    assert f'id="{section}"' not in pages["straight"]


def test_a_page_names_the_tables_that_hold_something(pages):
    made_from = re.search(r"<dt>made from</dt><dd>(.*?)</dd>", pages["straight"])
    assert made_from is not None
    files = made_from[1].split(", ")
    assert "ablation.csv" in files
    assert not {"table-4-1.csv", "agreement.csv", "sweep-throws.csv"} & set(files)


def test_what_leaving_out_pays_is_on_the_page(pages):
    section = re.search(r'<section id="left-out">.*?</section>', pages["straight"], re.DOTALL)
    assert section is not None
    assert "tumble:rk4" in section[0]
    assert "tumble ablate die-straight" in section[0]
    for feature in ("tether", "floor", "drag", "rotation"):
        assert feature in section[0]
