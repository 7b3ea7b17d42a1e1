"""What a result has: tables with units and meanings, its answer, its page in a frame, its figure, and its files."""

import re

import altair
import pandas as pd
import pytest

import tumble
from tumble.compare.tables.known import schema

# Attributes of a notebook's body that state its theme, their values, and whether that is dark.
THEMES = {
    "data-vscode-theme-kind": {
        "vscode-dark": True,
        "vscode-light": False,
        "vscode-high-contrast": True,
        "vscode-high-contrast-light": False,
    },
    "data-jp-theme-light": {"false": True, "true": False},
}


@pytest.fixture(scope="module")
def result() -> tumble.Result:
    return tumble.compare("two-hits", ["tumble:rk4", "tumble:exact"], film=True)


def test_every_table_is_an_attribute_with_units_and_meanings(result):
    for file, table in result.tables.items():
        found = getattr(result, file.removesuffix(".csv").replace("-", "_"))
        assert list(table.columns) == list(schema(file).names)
        assert found.drop(columns="contestant", errors="ignore").equals(table)
        assert set(found.attrs["meanings"]) == set(found.columns)
        assert found.attrs["table"] == schema(file).meaning
    assert set(result.runs["contestant"]) == {"tumble:rk4", "tumble:exact"}
    assert result.runs.attrs["units"]["max_error_m"] == "m"
    assert result.conditions is result.tables["conditions.csv"]
    assert {"runs", "vertex_errors", "plot", "save"} <= set(dir(result))
    with pytest.raises(AttributeError, match=r"no rums; tables: .*runs"):
        _ = result.rums


def test_the_answer_names_the_scene_and_the_text_the_contestants(result):
    assert "two-hits" in result.answer
    assert "\n" not in result.answer
    assert "tumble:rk4" in str(result)


def test_what_is_saved_is_read_and_saved_again_byte_for_byte(result, tmp_path):
    result.save(tmp_path / "one")
    read = tumble.read(tmp_path / "one")
    read.save(tmp_path / "two")
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert {"runs.csv", "conditions.csv", "datapackage.json"} <= set(names)
    assert names == sorted(path.name for path in (tmp_path / "two").iterdir())
    assert [
        name for name in names if (tmp_path / "one" / name).read_bytes() != (tmp_path / "two" / name).read_bytes()
    ] == []
    assert read.runs.attrs == result.runs.attrs


def test_what_the_command_writes_beside_its_tables_is_saved_too(result, tmp_path):
    tumble.Result(result.tables, documents={"releases.md": "# Releases\n"}).save(tmp_path, parquet=True)
    assert (tmp_path / "releases.md").read_text(encoding="utf-8") == "# Releases\n"
    assert (tmp_path / "runs.csv").is_file()
    assert pd.read_parquet(tmp_path / "runs.parquet").max_error_m.tolist() == result.runs.max_error_m.tolist()


def test_a_folder_without_tables_is_refused_in_one_line(tmp_path):
    with pytest.raises(tumble.UserError, match="has no tables") as refused:
        tumble.read(tmp_path)
    assert "\n" not in str(refused.value)


def test_the_figure_is_altairs(result):
    drawn = result.plot()
    assert isinstance(drawn, altair.TopLevelMixin)
    assert "rk4" in str(drawn.to_dict())


def test_in_a_notebook_it_is_a_page_whose_style_and_the_notebooks_do_not_meet(result, browser, tmp_path):
    """The notebook's style would colour every cell; the page's own has rules for `body`, `table` and `td`."""
    outside = "<style>* { color: rgb(255, 0, 0) !important } table { display: none !important }</style><p id=own>x</p>"
    file = tmp_path / "notebook.html"
    file.write_text(f"<!doctype html>{outside}{result._repr_html_()}", encoding="utf-8")
    context = browser.new_context(viewport={"width": 1000, "height": 900}, offline=True)
    context.set_default_timeout(120_000)
    tab = context.new_page()
    errors: list[str] = []
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.goto(file.as_uri())
    before = tab.evaluate("getComputedStyle(document.querySelector('#own')).fontFamily")
    frame = tab.frame_locator("iframe")
    frame.get_by_text("two-hits").first.wait_for(state="attached")
    table = frame.locator("table").first
    table.wait_for(state="attached")
    assert table.evaluate("one => getComputedStyle(one).display") != "none"
    assert frame.locator("body").evaluate("one => getComputedStyle(one).color") != "rgb(255, 0, 0)"
    assert tab.evaluate("getComputedStyle(document.querySelector('#own')).fontFamily") == before
    assert "Times" in before or "serif" in before, "the notebook has the page's font"
    assert "rk4" in frame.locator("body").inner_text()
    assert result.answer in tab.locator("body").inner_text()
    assert tab.evaluate("document.documentElement.scrollWidth") <= 1000
    tab.screenshot(path=tmp_path / "notebook.png")
    assert errors == []
    context.close()


def test_in_a_notebook_the_page_is_light_or_dark_as_the_notebook_is(result, browser):
    """By the attributes that VS Code and JupyterLab give their body, changed as a user changes the theme."""
    context = browser.new_context(color_scheme="null", offline=True)  # an emulated scheme would overrule the frame's
    context.set_default_timeout(120_000)
    tab = context.new_page()
    tab.set_content(result._repr_html_())
    tab.frame_locator("iframe").get_by_text("two-hits").first.wait_for(state="attached")
    page = tab.frames[-1]
    for attribute, themes in THEMES.items():
        for theme, dark in themes.items():
            tab.evaluate("([name, value]) => document.body.setAttribute(name, value)", [attribute, theme])
            query = f"(prefers-color-scheme: {'dark' if dark else 'light'})"
            page.wait_for_function("query => matchMedia(query).matches", arg=query, timeout=20_000)
            colour = page.evaluate("getComputedStyle(document.body).backgroundColor")
            assert (max(map(int, re.findall(r"\d+", colour))) < 128) == dark, (attribute, theme, colour)
        tab.evaluate("name => document.body.removeAttribute(name)", attribute)
    context.close()
