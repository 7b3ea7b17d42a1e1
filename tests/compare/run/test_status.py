from itertools import product

import pytest

from tumble.compare.run.process.message import PREFIX, Malformed, frame, unpacked
from tumble.compare.run.status import Failure, Status, described


@pytest.mark.parametrize(
    ("status", "reason", "text"),
    [
        (Status.OK, "", "ok"),
        (Status.SKIPPED, "no floor", "skipped: no floor"),
        (Status.DIVERGED, "at 2 s", "diverged at 2 s"),
        ("diverged", "at 2 s", "diverged at 2 s"),
    ],
)
def test_a_status_and_its_reason_are_one_text(status, reason, text):
    assert described(status, reason) == text


@pytest.mark.parametrize(("status", "died"), [*product(Status, (False, True))])
def test_a_failure_passes_between_processes(status, died):
    sent = Failure(status, "why: this", died)
    parts = [bytes(part) for part in frame(sent)]
    found = unpacked(Failure, parts[0][PREFIX.size :], b"")
    assert found == sent
    assert found.status is status


@pytest.mark.parametrize("status", ["fine", 3, None])
def test_a_status_that_is_none_is_refused(status):
    parts = [bytes(part) for part in frame({"status": status, "reason": "", "process_died": False})]
    with pytest.raises(Malformed, match="Status"):
        unpacked(Failure, parts[0][PREFIX.size :], b"")
