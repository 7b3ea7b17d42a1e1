"""What the page carries is what the tables say."""

import base64
import json
import math

import numpy as np
import pandas as pd
import pytest
from conftest import SCENES, data_in

from tumble.compare.judge.verdict import WORDS
from tumble.reports.embedding import values
from tumble.reports.page import TEMPLATES, page
from tumble.scenarios.frames import rotation_matrix

PACKED = {"motion.csv", "deformed.csv", "vertex-errors.csv", "error-over-time.csv", "table-4-1.csv"}


def column(carried: dict, name: str) -> list:
    held = carried["values"][name]
    if not isinstance(held, dict):
        return held
    return [(held.get("words") or held["numbers"])[at] for at in held["at"]]


def test_every_table_is_carried_to_the_last_digit(real, html):
    carried = data_in(html)["tables"]
    whole = {name for name, table in real.items() if len(table)} - PACKED
    assert whole <= set(carried)
    for name in whole:
        for title in real[name].columns:
            for told, value in zip(column(carried[name], title), real[name][title], strict=True):
                if pd.isna(value):
                    assert told is None
                elif isinstance(value, float) and math.isinf(value):
                    assert told == "Infinity"
                else:
                    assert told == value


def frames(text: str, width: int) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f4").reshape(-1, width).astype(float)


@pytest.mark.parametrize("scene", SCENES)
def test_a_film_puts_every_vertex_where_the_motion_says(real, html, scene):
    """In single precision: 24 bits of the largest coordinate and of a turn by up to pi, a few roundings each."""
    film = data_in(html)["films"][scene]
    motion = real["motion.csv"]
    points = real["points.csv"].query("scene == @scene")[["x_m", "y_m", "z_m"]].to_numpy()
    own = motion[motion["scene"] == scene]
    true = own[own["engine"] == "truth"]
    size = np.abs(true[["x_m", "y_m", "z_m"]].to_numpy()).max() + np.linalg.norm(points, axis=1).max()
    assert film["t"] == true["t_s"].tolist()
    carried = frames(film["truth"], 16)
    assert len(film["runs"]) > 3
    for name, packed in film["runs"].items():
        engine, _, method = name.partition(":")
        told = own[(own["engine"] == engine) & (own["method"] == method)]
        one = frames(packed["frames"], 10)
        assert len(one) == len(told)
        x = carried[: len(one), 0:3] + one[:, 0:3]
        turn = rotation_matrix(one[:, 3:7]) @ rotation_matrix(carried[: len(one), 3:7])
        q = told[["qw", "qx", "qy", "qz"]].to_numpy()
        assert np.abs(x - told[["x_m", "y_m", "z_m"]].to_numpy()).max() < 8 * 2**-24 * size
        assert np.abs(turn - rotation_matrix(q)).max() < 32 * 2**-24
        assert np.allclose(one[:, 7], told["error_m"], rtol=2**-23, atol=1e-44)


def test_the_deformed_die_is_carried_as_it_is(real, html):
    film = data_in(html)["films"]["die-vertex"]
    told = real["deformed.csv"].query("scene == 'die-vertex'")
    assert {name for name, one in film["runs"].items() if "vertices" in one} == {"tumble:matrix-euler"}
    carried = frames(film["runs"]["tumble:matrix-euler"]["vertices"], 3)
    assert np.allclose(carried, told[["x_m", "y_m", "z_m"]], rtol=2**-23, atol=1e-6)


def test_nothing_in_the_data_ends_the_script(real):
    evil = dict(real)
    evil["scenes.csv"] = real["scenes.csv"].assign(title="</script><script>alert(1)</script>")
    html = page(evil)
    assert "</script><script>alert" not in html
    titles = data_in(html)["tables"]["scenes.csv"]["values"]["title"]
    assert titles["words"] == ["</script><script>alert(1)</script>"]


def test_every_verdict_of_stability_has_a_sign_of_its_own_and_words():
    text = (TEMPLATES / "js/verdicts.js").read_text(encoding="utf-8")
    block = text.split("const STABILITY_VERDICTS = {")[1].split("};")[0]
    signs = {}
    for line in block.strip().splitlines():
        word, _, rest = line.strip().partition(":")
        signs[word.strip('"')] = json.loads(rest.strip().rstrip(","))
    assert set(signs) == set(WORDS)
    assert len({sign for sign, _ in signs.values()}) == len(signs), "colour alone must not distinguish them"


def test_the_same_tables_make_the_same_page(real, html):
    assert page(dict(real)) == html


def test_a_number_that_stands_there_often_is_carried_once_and_keeps_its_sign():
    told = values(pd.Series([0.0, -0.0, math.inf, math.nan] * 5))
    assert isinstance(told, dict)
    assert len(told["numbers"]) == 4
    back = [told["numbers"][at] for at in told["at"]]
    assert [math.copysign(1.0, number) for number in back[:2]] == [1.0, -1.0]
    assert back[2:4] == ["Infinity", None]
    assert values(pd.Series([1.0, 2.0, 3.0])) == [1.0, 2.0, 3.0]
