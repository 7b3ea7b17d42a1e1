"""One colour an engine: whoever else takes part, on the page and in the lab."""

import re

from tumble.compare.engines import BY_HAND
from tumble.compare.run.engines.registry import names
from tumble.reports.hues import LIGHT, PLACES, places
from tumble.reports.page import TEMPLATES


def test_an_engine_has_its_colour_whoever_takes_part_with_it():
    assert places(["mujoco"]) == {"mujoco": places(["tumble", "heyoka", "mujoco"])["mujoco"]}
    assert places(["mujoco@3.10.0"])["mujoco@3.10.0"] == places(["mujoco"])["mujoco"]


def test_places_are_of_engines_that_there_are_and_each_has_one():
    assert set(PLACES) | {BY_HAND} == set(names())
    assert len(set(PLACES)) == len(PLACES)


def test_an_engine_of_the_users_takes_a_colour_that_nobody_has():
    found = places(["tumble", "mine", "pybullet", "yours"])
    assert len({LIGHT[place % len(LIGHT)] for place in found.values()}) == 4
    many = places([f"mine{number}" for number in range(9)])
    assert len(set(many.values())) == 9


def test_the_page_has_the_same_colours():
    css = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    light = css[: css.index("prefers-color-scheme: dark")]
    assert tuple(re.findall(r"--hue-\d: (#\w{6})", light)) == LIGHT
