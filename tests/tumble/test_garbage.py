"""What is imported is not looked through by later garbage collections."""

import gc
import importlib

import pytest

from tumble.garbage import importing, without_garbage_collection


@pytest.fixture
def frozen():
    """Return how much is not looked through; afterwards, all is again."""
    yield gc.get_freeze_count
    gc.unfreeze()


def test_what_is_imported_is_not_looked_through_again(frozen, tmp_path, monkeypatch):
    (tmp_path / "of_a_test.py").write_text("made = [[] for _ in range(1000)]\n")
    monkeypatch.syspath_prepend(tmp_path)
    before = frozen()
    with importing():
        assert not gc.isenabled()
        made = importlib.import_module("of_a_test").made
    assert gc.isenabled()
    assert frozen() >= before + len(made)


def test_garbage_is_not_kept_where_all_is_imported_already(frozen):
    before = frozen()
    with importing():
        importlib.import_module("gc")
    assert frozen() == before


def test_a_failed_import_leaves_the_collection_as_it_was(frozen):
    with pytest.raises(ImportError), importing():
        raise ImportError
    assert gc.isenabled()


def test_one_within_another_one_does_not_begin_it_too_early():
    with without_garbage_collection():
        with without_garbage_collection():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()
