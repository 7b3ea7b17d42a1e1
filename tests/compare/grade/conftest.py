"""The clock by which a search stops is slow here: an answer must not depend on how busy the machine is."""

import pytest

from tumble.compare.grade.search import causal, closing, diagnosis, simulations
from tumble.compare.grade.search.clock import search_clock

SLOWER = 20


@pytest.fixture(autouse=True)
def slow_clock(monkeypatch):
    """Count a twentieth of the processor time, in the search and in its limit."""
    for module in (causal, closing, diagnosis, simulations):
        monkeypatch.setattr(module, "search_clock", lambda: search_clock() / SLOWER)
