"""The page's modules: each is one script, after those it imports from, and its lines keep their numbers."""

import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path

import pytest

from tools.page_types import COMPILER, FILE, checked, declarations
from tumble.reports.modules import JAVASCRIPT, page_scripts
from tumble.reports.page import page


def names(scripts: list[str]) -> list[str]:
    return [found for script in scripts for found in re.findall(r"^//# sourceURL=(.*)$", script, re.MULTILINE)]


def module_folder(folder: Path, modules: Mapping[str, str]) -> Path:
    for name, text in modules.items():
        (folder / f"{name}.js").write_text(text, encoding="utf-8")
    return folder


def test_every_module_is_on_the_page_once_and_ends_no_script_element():
    scripts = page_scripts()
    assert sorted(names(scripts)) == sorted(path.name for path in JAVASCRIPT.glob("*.js"))
    assert not any(re.search(r"</script|<!--", script, re.IGNORECASE) for script in scripts)


def test_a_module_stands_after_those_it_imports_from(tmp_path):
    modules = {
        "main": 'import { b } from "./b.js";\nimport { c } from "./c.js";\n',
        "b": 'import { c } from "./c.js";\n\nexport const b = c + 1;\n',
        "c": "export const c = 1;\n",
        "unused": "throw 1;\n",
    }
    assert names(page_scripts(module_folder(tmp_path, modules))) == ["c.js", "b.js", "main.js"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('import * as b from "./b.js";', r"main\.js: import \*"),
        ('import b from "./b.js";', r"main\.js: import b"),
        ("export default 3;", r"main\.js: export default"),
        ("export let count = 0;", r"main\.js: export let"),  # an importer would see its first value for ever
        ('import { missing } from "./b.js";', r"main\.js: imports missing"),
        ('import { b } from "./circle.js";', r"circle\.js|circle"),
    ],
)
def test_what_cannot_be_assembled_is_refused(tmp_path, line, message):
    modules = {
        "main": f"{line}\n",
        "b": "export const b = 1;\n",
        "circle": 'import { a } from "./other.js";\nexport const b = a;\n',
        "other": 'import { b } from "./circle.js";\nexport const a = b;\n',
    }
    with pytest.raises(ValueError, match=message):
        page_scripts(module_folder(tmp_path, modules))


def test_an_error_names_the_file_and_the_line(real, browser, tmp_path, monkeypatch):
    modules = {path.stem: path.read_text(encoding="utf-8") for path in JAVASCRIPT.glob("*.js")}
    lines = modules["provenance"].splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("export function provenanceSection"))
    lines.insert(at + 1, '  throw new Error("on purpose");')
    folder = module_folder(tmp_path, modules | {"provenance": "\n".join(lines)})
    monkeypatch.setattr("tumble.reports.page.page_scripts", lambda: page_scripts(folder))
    file = tmp_path / "report.html"
    file.write_text(page(real), encoding="utf-8")
    tab = browser.new_page()
    errors = []
    tab.on("pageerror", lambda error: errors.append(error.stack))
    tab.goto(f"{file.as_uri()}#at=how")
    tab.wait_for_timeout(200)
    tab.close()
    assert len(errors) == 1
    assert f"provenanceSection (provenance.js:{at + 2}:" in errors[0]
    assert "main.js" in errors[0]


def test_the_types_of_rows_are_those_of_the_tables():
    """After a change of a column: `make types`."""
    assert FILE.read_text(encoding="utf-8") == declarations()


@pytest.mark.skipif(
    not (shutil.which("npm") and (COMPILER.exists() or "CI" in os.environ)), reason="TypeScript is not installed"
)
def test_misspelt_names_of_data_and_an_empty_cell_are_found(tmp_path, capfd):
    lines = {
        "rows('runs.csv').map((run) => run.max_error);": "Property 'max_error' does not exist",
        "rows('run.csv');": "'\"run.csv\"' is not assignable",
        "rows('runs.csv').map((run) => run.max_error_m.toFixed(3));": "'run.max_error_m' is possibly 'null'",
        "findings('the nearest');": "'\"the nearest\"' is not assignable",
    }
    for name in ("data.js", "page.d.ts", "tables.d.ts", "tsconfig.json"):
        shutil.copy(JAVASCRIPT / name, tmp_path)
    (tmp_path / "main.js").write_text(
        "\n".join(['import { findings, rows } from "./data.js";', *lines]), encoding="utf-8"
    )
    assert checked(tmp_path) != 0
    said = capfd.readouterr().out
    assert [message for message in lines.values() if message in said] == list(lines.values())
