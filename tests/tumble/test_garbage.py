"""What is imported is not looked through by later garbage collections."""

import gc

import pytest

from tumble.garbage import importing, without_garbage_collection


@pytest.fixture
def frozen():
    """Return how much is not looked through; afterwards, all is again."""
    yield gc.get_freeze_count
    gc.unfreeze()


def test_what_is_imported_is_not_looked_through_again(frozen):
    before = frozen()
    with importing():
        assert not gc.isenabled()
        made = [[] for _ in range(1000)]
    assert gc.isenabled()
    assert frozen() >= before + len(made)


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
