"""What a page is sent as HTML: names from files are text, and the numbers are those of the table."""

import numpy as np

from tumble.lab.foreign import Foreign
from tumble.lab.looks import Look
from tumble.lab.markup import error_table, grade_box, readings_table, status_line
from tumble.lab.pool import Contestant
from tumble.lab.readings import ErrorRow, Reading
from tumble.lab.sentences import printed
from tumble.lab.session import Shown
from tumble.scenarios.published import table_4_1

EVIL = "<img src=x onerror=alert(1)>"
LOOK = Look((1, 2, 3), "o", "")


def test_what_comes_from_a_file_is_text():
    mine = Contestant(f"./{EVIL}.py", "rk4", EVIL)
    row = ErrorRow(mine, 0, np.zeros(3), np.ones(3), 3**0.5, 0.0, f"flagged: {EVIL}")
    gone = ErrorRow(mine, None, None, None, np.nan, np.nan, f"crashed: {EVIL}")
    pages = (
        error_table([row, gone], {mine: LOOK}, 1.0, None, 0.5),
        grade_box(Foreign(EVIL, np.zeros(1), np.zeros((1, 8, 3)), f"Off: {EVIL}", False, (EVIL,))),
        status_line(f"{EVIL}\x1b[2J: no such file", is_refusal=True),
    )
    for page in pages:
        assert "<img" not in page
        assert "&lt;img" in page
        assert "\x1b" not in page


def test_an_error_below_the_limit_is_shown_as_the_limit():
    one = Contestant("mujoco", "rk4", "mujoco")
    row = ErrorRow(one, 3, np.zeros(3), np.full(3, 1e-16), 2e-16, 1e-15, "")
    assert "≤" in error_table([row], {one: LOOK}, 1.0, 3, 0.5)


def test_the_table_names_the_vertex_of_each():
    one = Contestant("mujoco", "rk4", "mujoco")
    row = ErrorRow(one, 6, np.zeros(3), np.full(3, 1e-3), 2e-3, 1e-15, "")
    assert ">vertex 6</span>" in error_table([row], {one: LOOK}, 1.0, None, 0.5)


def test_a_number_that_is_not_there_yet_is_a_dash():
    assert "\N{EN DASH}" in readings_table([Reading("hit point", "m", ())], 1.0)


def test_the_coursework_cube_is_shown_in_two_decimals_as_printed():
    assert ">2.50</td>" in readings_table([Reading("centre of mass", "m", (0.0, 2.5, 0.0))], 5.0)


def test_the_printed_positions_are_held_against_what_is_shown_at_their_own_times():
    table = table_4_1()
    vertices = np.zeros((8, 3))
    vertices[5] = table.application[2]
    line = printed(Shown(18, float(table.physics_times[2]), np.zeros(13), vertices))
    assert "0 m from the truth" in line
    assert "m" in printed(Shown(0, 0.0, np.zeros(13), vertices))


def test_long_numbers_are_let_go_into_lines_of_their_own():
    centre = 1000.0, 0.0, -2000.0
    short, long = (readings_table([Reading("centre of mass", "m", centre)], size) for size in (5.0, 4e-4))
    assert short.count("<span") == 0
    assert long.count("display:inline-block") == 3
    assert "\N{MINUS SIGN}2000.000000<" in long
