"""Workers and the scheduler are killed at random moments of a run: every row once, bytes as without them."""

import pytest

from tools.kill_workers import check, run_here
from tumble.compare.run.task_cache import TaskCache

pytest.importorskip("distributed")


@pytest.mark.parametrize(
    ("tasks", "kills", "end_scheduler"), [(120, 3, True), (2000, 30, False), (2000, 0, True)],
    ids=["3 kills and the scheduler", "30 kills", "the scheduler"],
)  # fmt: skip
def test_every_row_is_there_once_and_equal(tasks, kills, end_scheduler, tmp_path):
    expected = TaskCache(tmp_path / "here")
    run_here(tasks, expected)
    assert check("killed", tasks, 4, kills, end_scheduler, expected)
