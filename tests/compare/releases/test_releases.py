"""The ledger of releases: what changed is found from the numbers, nothing else is, and it goes on where it was."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from apart import engine

from tumble.compare.contact.schemas import ContactRow
from tumble.compare.releases.changes import changes
from tumble.compare.releases.ledger import Ledger, ledger
from tumble.compare.releases.notes import Notes, shipped_notes
from tumble.compare.releases.schemas import ReleaseRow
from tumble.compare.run.engines.environments import folder, in_order
from tumble.compare.run.execution import resumable
from tumble.compare.run.running_engines import launched
from tumble.compare.run.timing.readings import Reading, Sampling
from tumble.reports.releases import answer, ledger_markdown, ledger_text, sentence
from tumble.scenarios.read import read_scene

RELEASES = ("3.9.0", "3.10.0", "4.0.0")
ROW = ReleaseRow(
    engine="mujoco",
    release="",
    scene="brick-tumble",
    method="rk4",
    dt_s=0.002,
    status="ok",
    why="",
    max_error_m=2e-5,
    resolution_m=1e-13,
    energy_drift=1e-9,
    angular_momentum_drift=1e-9,
    attitude_order=2.0,
    translation_order=None,
    spin_energy="conserved",
    step_ns=3000.0,
)
NOTES = """
Changelog
=========

Version 4.0.0 (November 6, 2026)
--------------------------------
1. :commit:`9a7f240f0` The ``RK4`` :ref:`integrator<option-integrator>` is now fourth-order
   accurate. More.
- ``rk45`` is another.

Version 3.10.0
--------------
- Nothing about it.
"""


def planted(*changed: ReleaseRow, speeds=None) -> Ledger:
    same = [replace(ROW, release=release) for release in RELEASES]
    rows = {(row.release, row.scene, row.method): row for row in (*same, *changed)}
    return Ledger("mujoco", RELEASES, tuple(rows.values()), speeds or {})


def test_where_nothing_changed_nothing_is_told():
    own = planted(replace(ROW, release="4.0.0", max_error_m=2.001e-5, attitude_order=2.1))
    assert list(changes(own, Notes(NOTES))) == []
    assert "none behaves differently" in answer(own, [])


def test_below_what_the_truth_can_tell_nothing_is_told():
    own = [
        replace(ROW, release=release, max_error_m=off)
        for release, off in zip(RELEASES, (2e-13, 9e-13, 1e-14), strict=True)
    ]
    assert list(changes(planted(*own), Notes(""))) == []


def test_what_changed_is_told_with_the_notes_own_words():
    own = planted(replace(ROW, release="4.0.0", max_error_m=5e-10, attitude_order=4.1))
    order, error = changes(own, Notes(NOTES))
    assert (order.release, order.before, order.method, order.what) == ("4.0.0", "3.10.0", "rk4", "attitude_order")
    assert sentence(order) == "attitude order: 2.0 -> 4.1 (brick-tumble)"
    assert sentence(error) == "largest error: 2e-05 m -> 5e-10 m (brick-tumble)"
    assert order.notes == "The RK4 integrator is now fourth-order accurate. More."
    assert "4.0.0 behaves differently" in answer(own, [order, error])
    page = ledger_markdown(own, [order, error], "tumble releases mujoco")
    assert "| 4.0.0 | rk4 | attitude order: 2.0 -&gt; 4.1" in page.replace("->", "-&gt;")
    assert "\n    tumble releases mujoco\n" in page
    assert list(ledger_text(own, [order, error]))


def test_a_method_that_comes_a_status_and_a_trend_are_changes():
    found = changes(
        planted(
            replace(ROW, release="4.0.0", method="discrete"),
            replace(ROW, release="3.10.0", status="diverged", why="at 3 s", max_error_m=np.inf),
            replace(ROW, release="4.0.0", spin_energy="grows"),
        ),
        Notes(""),
    )
    told = [(row.release, row.method, row.what) for row in found]
    assert told == [
        ("3.10.0", "rk4", "status"),
        ("3.10.0", "rk4", "max_error_m"),
        ("4.0.0", "rk4", "status"),
        ("4.0.0", "rk4", "spin_energy"),
        ("4.0.0", "rk4", "max_error_m"),
        ("4.0.0", "discrete", "method"),
    ]


@pytest.mark.parametrize(("faster", "told"), [(1.1, 0), (2.0, 1)])
def test_a_time_is_told_where_its_interval_leaves_no_doubt(faster, told):
    noise = 1.0 + 0.02 * np.sin(np.arange(40))
    speeds = {(release, "rk4"): Reading(1000.0 * noise) for release in RELEASES[:2]}
    speeds["4.0.0", "rk4"] = Reading(1000.0 / faster * noise)
    found = list(changes(planted(speeds=speeds), Notes("")))
    assert [(row.release, row.what) for row in found] == [("4.0.0", "time")] * told


def test_releases_are_in_the_order_of_their_numbers():
    assert in_order(["3.10.0", "3.9.0", "4.0.0rc1", "3.9.0.post1"]) == ["3.9.0", "3.9.0.post1", "3.10.0"]


def test_the_notes_of_mujoco_are_shipped_and_read():
    notes = shipped_notes("mujoco")
    assert "fourth-order accurate" in notes.about("4.0.0", "rk4")
    assert "midpoint" in notes.about("3.11.0", "implicitfast+held")
    assert notes.about("3.9.0", "rk4") == ""


def test_it_finds_what_changed_in_mujoco_and_nothing_else(tumble, tmp_path, monkeypatch):
    with engine("mujoco@3.10.0"):
        pass
    (tmp_path / "environments").mkdir()
    (tmp_path / "environments" / "mujoco@3.10.0").symlink_to(folder() / "mujoco@3.10.0")
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path / "environments"))
    done = tumble("releases", "mujoco", "brick-tumble", "-o", "ledger")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "ledger" / "release-changes.csv").read_text().splitlines()))
    found = {(row["release"], row["method"], row["what"]) for row in rows if row["what"] != "time"}
    assert ("4.0.0", "rk4", "attitude_order") in found
    assert ("4.0.0", "implicitfast", "attitude_order") in found, "from the midpoint rule to implicit Euler"
    assert {method for _, method, _ in found} == {"rk4", "implicitfast", "discrete"}, "euler and implicit are unchanged"
    assert done.stdout.startswith("mujoco, 2 releases from 3.10.0 to 4.0.0: 4.0.0 behaves differently")
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "\\n" not in done.stdout, "control characters are made visible: a line is a line of its own"
    assert not (tmp_path / "ledger" / ".unfinished").exists()


def test_it_goes_on_where_it_was_interrupted(tmp_path):
    scene = read_scene("die-straight")
    with launched(["mujoco@4.0.0"]) as running_engines:
        flown = []
        simulate = running_engines[0].simulate

        def counted(scene, method, dt, **more):
            flown.append(method)
            return simulate(scene, method, dt, **more)

        def interrupt(what):
            if what.endswith("rk4"):
                raise KeyboardInterrupt

        running_engines[0].simulate = counted
        with pytest.raises(KeyboardInterrupt), resumable(tmp_path):
            ledger(running_engines, [scene], interrupt)
        before = {*flown}
        flown.clear()
        with resumable(tmp_path):
            found = ledger(running_engines, [scene], sampling=Sampling(0.0, 4, 0.1))
    assert {"euler", "rk4"} <= before
    assert not {"euler", "rk4"} & {*flown}
    assert {row.method for row in found.rows} >= {"euler", "rk4", "implicit"}
    assert all(row.step_ns for row in found.rows)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("handcalc",), "handcalc has no releases of its own"),
        (("nope",), "unknown engine 'nope'"),
        (("mujoco:rk4",), "type `tumble releases mujoco`"),
        (("mujoco@3.6.0",), "type `tumble releases mujoco --from 3.6.0`"),
        (("mujoco@3.6.0", "mujoco@4.0.0"), "type `tumble releases mujoco --from 3.6.0 --to 4.0.0`"),
        (("mujoco", "mujoco@4.0.0"), "type `tumble releases mujoco --to 4.0.0`"),
        (("mujoco", "--from", "99.0"), "mujoco: at least two releases are needed; installed: "),
        (("mujoco", "--from", "newest"), "mujoco has no release newest; choose one of "),
    ],
)
def test_wrong_words_are_one_line(tumble, words, said):
    done = tumble("releases", *words)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert said in line


def observed(verdict: str, law_error: float, half: float = 1e-4) -> list[ContactRow]:
    """Return the rows of a rebound of 2 m/s with that law error, known to half of an interval."""
    return [
        ContactRow(
            scene="ball", engine="mujoco", method="rk4", dt_s=1e-3, tolerance=None,
            observable="rebound speed after impact",
            blow=1, value=2.0 + law_error, true=2.0, unit="m/s", error=law_error, law_error=law_error,
            law_error_low=law_error - half, law_error_high=law_error + half, step_error=0.0, order=1.0, verdict=verdict,
        )
    ]  # fmt: skip


def test_a_law_of_contact_that_breaks_and_is_mended_is_told_at_its_releases():
    own = replace(
        planted(*(replace(ROW, release=release, scene="ball") for release in RELEASES)),
        contact={
            ("3.9.0", "ball", "rk4"): observed("Coulomb and Newton", 5e-5),
            ("3.10.0", "ball", "rk4"): observed("no restitution", -2.0),
            ("4.0.0", "ball", "rk4"): observed("Coulomb and Newton", 0.0),
        },
    )
    found = list(changes(own, Notes("")))
    assert [(row.release, row.what) for row in found] == [
        (release, what) for release in RELEASES[1:] for what in ("contact", "law_error")
    ]
    assert sentence(found[0]) == "law of contact: Coulomb and Newton -> no restitution (ball)"
    assert sentence(found[1]) == "law error: rebound speed after impact 1 5e-05 m/s -> -2 m/s (ball)"
    within = own.contact | {("3.10.0", "ball", "rk4"): observed("Coulomb and Newton", 1.5e-4)}
    assert list(changes(replace(own, contact=within), Notes(""))) == [], "intervals that overlap are one law"
