"""The mistakes of a file that `tumble grade` explains."""

from pathlib import Path

from tumble.compare.grade.grade import EXPLAINED_WHOLLY, SEARCH_S, grade


def explained(file, scene, search_s=SEARCH_S):
    """Return the mistakes of a file that is explained, by name: their values; search_s: of processor time [s]."""
    found = grade(Path(file), scene, {}, search_s=search_s)
    assert found.verdict == EXPLAINED_WHOLLY, found.diagnosis.best.names
    return {mistake.hypothesis.name: mistake.value for mistake in found.diagnosis.best.mistakes}
