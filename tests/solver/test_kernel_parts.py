"""How kernels are compiled: numba's own way but for what takes time."""

import gc

import numpy as np
import pytest
from numba import types
from numba.core.errors import TypingError
from numba.extending import overload

from tumble.solver.compilation import kernel_with

SEEN = []


def observed(x):
    """Return x, and note while a call is compiled whether garbage is collected."""
    return x


@overload(observed)
def _observed(x):
    SEEN.append(gc.isenabled())
    return (lambda x: x) if isinstance(x, types.Float) else None


def observing(rows):
    return observed(rows[0])


@pytest.fixture(autouse=True)
def unsaved(tmp_path, monkeypatch):
    """Save nothing for the next test, which would compile nothing."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    SEEN.clear()


def test_no_garbage_is_collected_while_a_kernel_is_compiled():
    assert gc.isenabled()
    assert kernel_with()(observing)(np.ones(3)) == 1.0
    assert SEEN
    assert not any(SEEN)
    assert gc.isenabled()


def test_garbage_is_collected_again_after_what_cannot_be_compiled():
    with pytest.raises(TypingError):
        kernel_with()(observing)(np.ones(3, dtype=complex))
    assert SEEN
    assert gc.isenabled()


def test_who_collects_no_garbage_does_not_after_a_kernel_is_compiled():
    gc.disable()
    try:
        kernel_with()(observing)(np.ones(3))
        assert not gc.isenabled()
    finally:
        gc.enable()
