"""Who takes part in the lab's tests: real engines, started once."""

import threading
import time
from collections.abc import Callable, Iterator

import pytest
from lab_pages import opening

from tumble.lab.draft import Draft
from tumble.lab.pool import Pool
from tumble.lab.session import Session

WHO = ("tumble:rk4", "mujoco:euler", "pybullet:multibody")
PATIENCE_S = 180.0


@pytest.fixture(scope="session")
def pool() -> Iterator[Pool]:
    with Pool(time_limit=60.0) as pool:
        yield pool


@pytest.fixture
def session(pool, tmp_path) -> Iterator[Session]:
    """A session of its own on the coursework's cube, clicked by nobody yet."""
    session = Session(Draft.opened("table-4-1-ray"), pool.ready(WHO), pool, tmp_path, lambda: None)
    yield session
    session.close()


@pytest.fixture(scope="module")
def opened(browser) -> Iterator[Callable]:
    """Open labs in browsers of their own."""
    with opening(browser) as open_lab:
        yield open_lab


@pytest.fixture
def opened_here(browser) -> Iterator[Callable]:
    """Open labs in browsers of their own until the test ends: an open page takes a core for its pictures."""
    with opening(browser) as open_lab:
        yield open_lab


@pytest.fixture
def until() -> Callable[[Callable[[], bool]], None]:
    """Wait until something holds."""

    def wait(holds: Callable[[], object]) -> None:
        end = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end, "it never came"
            threading.Event().wait(0.02)

    return wait
