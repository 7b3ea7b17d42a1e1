"""A page made from a real, small run of everything, and a real browser to open it in, offline."""

import fcntl
import json
import os
import pickle
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from patience import PATIENCE_S
from playwright.sync_api import Page

from tumble.compare.comparison.against_truth import compare
from tumble.compare.comparison.results import comparison_tables
from tumble.compare.coursework.results import coursework_tables
from tumble.compare.motion.film import film
from tumble.compare.motion.findings import film_findings
from tumble.compare.motion.results import film_tables
from tumble.compare.run.running_engines import launched
from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.results import quick_tables
from tumble.compare.stability.schemas import EXTREMES, LIMITS
from tumble.compare.sweep.results import measured
from tumble.compare.sweep.work_precision import BRIEF, sweep
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.frames import frame, merged, rows
from tumble.compare.tables.shared import FINDINGS
from tumble.reports.page import page
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import frozen_array

SCENES = ("die-vertex", "table-4-1", "two-hits", "tether-critical")
CASES = ("spin-1e3", "spin-1e4", "step-1", "no-impulse")
ENGINES = (
    "tumble:rk4", "tumble:quaternion-euler", "tumble:matrix-euler", "handcalc", "mujoco:euler", "mujoco:rk4",
    "pybullet:multibody", "pybullet:multibody+defaults",
)  # fmt: skip
REFERENCE, COMMAND, BUDGET_S = "tumble:rk4", "tumble report", 0.01

Tables = Mapping[str, pd.DataFrame]


@contextmanager
def shared(factory: pytest.TempPathFactory, name: str) -> Iterator[Path]:
    """Yield a file that the processes of the tests share: the first one makes it while the others wait."""
    own = factory.getbasetemp()
    file = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "shared" / name
    file.parent.mkdir(exist_ok=True)
    with Path(f"{file}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield file


@pytest.fixture(scope="session")
def real(tmp_path_factory) -> dict[str, pd.DataFrame]:
    """All tables of a few scenes by a few contestants."""
    with shared(tmp_path_factory, "real.pickle") as file:
        if not file.exists():
            file.write_bytes(pickle.dumps(real_tables()))
        return pickle.loads(file.read_bytes())


def real_tables() -> dict[str, pd.DataFrame]:
    """Run the scenes and return their tables."""
    scenes = [read_scene(name) for name in SCENES]
    swept = replace(read_scene("yardstick"), duration=1.0, times=frozen_array([1.0]))
    with launched(ENGINES) as running_engines:
        comparisons = compare(running_engines, scenes)
        found = comparison_tables(comparisons, list(map(engine_row, running_engines)), COMMAND)
        films = film(running_engines, scenes)
        found |= film_tables(films)
        costs = measured([sweep(running_engines, swept, effort=replace(BRIEF, budget_s=BUDGET_S))], REFERENCE)
        found |= {f"sweep-{name}": table for name, table in costs.items() if name != FINDINGS.file}
        found |= quick_tables(running_engines, [scenes[-1]], [read_scene(name) for name in CASES])
    limits, verdicts = rows(LIMITS, found[LIMITS.file]), rows(EXTREMES, found[EXTREMES.file])
    said = [*film_findings(films), *limit_findings(limits), *extreme_findings(verdicts)]
    more = {FINDINGS.file: pd.concat([costs[FINDINGS.file], frame(FINDINGS, said)])}
    return merged(found, coursework_tables(comparisons), more)


@pytest.fixture(scope="session")
def html(real) -> str:
    return page(real)


@pytest.fixture(scope="session")
def whole_page(tmp_path_factory) -> Path:
    """The page of everything, as `make report` makes it: made once, by whichever process of the tests comes first."""
    with shared(tmp_path_factory, "tumble.html") as file:
        if not file.exists():  # it is written whole or not at all
            words = [sys.executable, "-P", "-m", "tumble", "report", "-o", str(file)]
            done = subprocess.run(words, cwd=file.parent, capture_output=True, text=True, timeout=2 * PATIENCE_S)
            assert done.returncode == 0, done.stderr
    return file


@pytest.fixture
def opened(browser, tmp_path) -> Iterator[Callable[..., Page]]:
    """Open a page from its file, offline; afterwards no request but for that file, and no word in the console."""
    contexts, heard, asked = [], [], []

    def open_page(html: str, address: str = "", width: int = 1280, height: int = 900, **settings) -> Page:
        file = tmp_path / "report.html"
        file.write_text(html, encoding="utf-8")
        size = {"width": width, "height": height}
        context = browser.new_context(viewport=size, offline=True, **{"reduced_motion": "reduce", **settings})
        context.set_default_timeout(120_000)  # as of tests/conftest.py
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda message: heard.append(message.text))
        tab.on("pageerror", lambda error: heard.append(str(error)))
        tab.on("dialog", lambda dialog: (heard.append(dialog.message), dialog.dismiss()))
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(file.as_uri() + address)
        until(tab, "document.documentElement.dataset.ready === 'yes'")
        return tab

    yield open_page
    for context in contexts:
        context.close()
    assert heard == []
    assert {url.partition("#")[0].rpartition("/")[2] for url in asked if url.startswith("file:")} == {"report.html"}
    # What the page makes itself, a picture of a figure, is no request to anybody.
    assert all(url.startswith(("file:///", "data:image/svg+xml", "blob:")) for url in asked)


def until(tab: Page, expression: str) -> None:
    """Wait until it is true; Playwright's own wait is a script of its own, which the page's policy keeps out."""
    end = time.monotonic() + PATIENCE_S
    while not tab.evaluate(expression):
        assert time.monotonic() < end, f"still not so: {expression}"
        tab.wait_for_timeout(50)


def data_in(html: str) -> dict:
    """Return what a page carries."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.DOTALL)
    assert found
    return json.loads(found[1])
