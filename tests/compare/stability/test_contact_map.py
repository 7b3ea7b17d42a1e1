"""The map of friction and angle, and the largest step: engines with a planted law of contact, and a real one."""

import math
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support import planted_contact
from tests.support.planted_contact import BALL, SLIDE, THIN
from tumble.compare.run.local import LocalEngine
from tumble.compare.run.running_engines import launched
from tumble.compare.stability.contact import TANGENTS, contact_piece
from tumble.scenarios.read import read_scene, scene_of


def pieces(text, *methods):
    """Return the pieces of planted laws by method."""
    scene = scene_of(text, Path("planted.toml"), "planted")
    with launched([LocalEngine("planted", SimpleNamespace(**{**vars(planted_contact), "METHODS": methods}))]) as (one,):
        return {method: contact_piece(one, method, scene) for method in methods}


def holds_to(piece):
    """Return the largest tangent over mu at which a body holds, one of each friction."""
    return {
        round(
            max(
                math.tan(row.angle_rad) / row.friction
                for row in piece.rows
                if row.friction == mu and row.verdict == "holds"
            ),
            9,
        )
        for mu in {row.friction for row in piece.rows}
    }


def test_the_map_has_the_critical_line_of_the_engine_s_friction():
    found = pieces(SLIDE.replace("0.004", "0.001"), "right", "another-friction", "creeps")
    right = found["right"].rows
    assert [row.verdict for row in right] == [row.true_verdict for row in right]
    assert {row.verdict for row in right} == {"holds", "slides"}
    assert [row.speed_m_s for row in right] == pytest.approx([row.true_speed_m_s for row in right], rel=0.1, abs=1e-9)
    assert holds_to(found["another-friction"]) == {max(it for it in TANGENTS if it < 1.25)}
    still = [row for row in found["creeps"].rows if row.true_verdict == "holds"]
    assert {row.verdict for row in still} == {"creeps"}
    assert max(row.speed_m_s for row in still) == pytest.approx(planted_contact.CREEP)


def test_a_box_tips_where_its_edge_is_too_near():
    """Where its edge is nearer than the slope, a box with more friction than that tips, and slides with less."""
    with launched(["tumble:moreau"]) as (ours,):
        rows = contact_piece(ours, "moreau", read_scene("box-incline-tips")).rows
    assert {row.true_verdict for row in rows} == {"holds", "slides", "tips"}
    assert [row.verdict for row in rows] == [row.true_verdict for row in rows]


def test_the_largest_step_is_where_the_law_breaks():
    found = {method: piece.step for method, piece in pieces(BALL, "right", "gains", "tunnels", "thin").items()}
    assert all(not piece.rows for piece in pieces(BALL, "right").values()), "a ball has no map"
    assert (found["right"].dt_max_s, found["right"].beyond) == (math.inf, "")
    assert (found["gains"].dt_max_s, found["gains"].beyond) == (None, "gains energy")
    assert (found["tunnels"].dt_max_s, found["tunnels"].beyond) == (None, "tunnels")
    # No step shorter than the plane is thick at the speed of the fall passes it; of longer ones only some do.
    fastest = math.sqrt(2 * 9.81 * 0.55)
    assert found["thin"].beyond == "tunnels"
    assert THIN / fastest <= found["thin"].dt_max_s <= 4 * THIN / fastest
