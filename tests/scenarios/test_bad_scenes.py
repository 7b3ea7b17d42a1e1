"""What cannot be read is refused in one line that names file, key, value and what is allowed; nothing else happens."""

import json
import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios.read import BadScene, read_scene
from tumble.scenarios.scene import Scene

BAD = sorted((Path(__file__).parents[1] / "bad").glob("*.toml"))
GOOD = 'title = "a"\nduration = 1.0\nsamples = 2\nstep = 0.1\n[body]\nshape = "box"\nsize = [1, 1, 1]\nmass = 1\n'


def refusal(name: str) -> str:
    with pytest.raises(BadScene) as refused:
        read_scene(name)
    line = str(refused.value)
    assert line.isprintable(), "not one line"
    return line


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_refused_in_the_line_its_first_line_expects(path):
    expected = path.read_bytes().splitlines()[0].decode().removeprefix("# expect: ")
    assert refusal(str(path)) == f"{path}: {expected}"


def test_the_folder_was_found():
    assert len(BAD) > 80


def test_an_unknown_name_offers_the_nearest_or_all():
    assert refusal("brik-tumble") == "unknown scene 'brik-tumble': did you mean 'brick-tumble'?"
    assert refusal("zzz").startswith("unknown scene 'zzz': there are brick-tumble, die-ray, ")
    assert refusal("a\nb").startswith(r"unknown scene 'a\nb': ")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("nowhere.toml", "nowhere.toml: no such file"),
        ("./nowhere", "./nowhere: no such file"),
        ("no\nwhere.toml", r"'no\nwhere.toml': no such file"),
        ("null\0.toml", r"'null\x00.toml': cannot be read: embedded null byte"),
        (os.devnull, f"{os.devnull}: cannot be read: not a plain file"),
    ],
)
def test_a_file_that_is_not_there(name, why):
    assert refusal(name) == why


def test_files_too_deep_too_long_or_too_large(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text("a = " + "[" * 100_000)
    assert refusal(str(file)).endswith("a.toml: not TOML: nested too deeply")
    file.write_text(".".join("a" * 5000) + " = 1")
    assert refusal(str(file)).endswith("a.toml: a: nested too deeply")
    file.write_text("a = " + "1" * 5000)
    assert "a.toml: not TOML: " in refusal(str(file))
    file.write_text("duration = 0x" + "f" * 5000)
    assert refusal(str(file)).endswith("a.toml: duration = a number of thousands of digits: must be finite")
    with file.open("wb") as sparse:
        sparse.truncate(100_000_001)
    assert refusal(str(file)).endswith("a.toml: cannot be read: larger than 100 MB")


def test_a_file_from_another_system_is_read(tmp_path):
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert read_scene(str(file)).name == "a"


# Numbers at which sums, squares and quotients overflow, underflow or lose their sign.
extremes = [0, -0.0, -1, 1e-9, 5e-324, 1e-200, 1e154, 1.7e308, 2**70, float("nan")]
numbers = st.sampled_from([1, 2.5, 0.5] * 30 + extremes)
scalars = st.sampled_from(extremes) | st.floats() | st.integers() | st.booleans() | st.text(max_size=5)
vectors = st.lists(numbers, min_size=3, max_size=3)
anything = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


def table(required: dict, optional: dict) -> st.SearchStrategy[dict]:
    """Tables that are mostly as the format has them, sometimes short of a key, sometimes with anything in its place."""
    sane = st.fixed_dictionaries(required, optional=optional)
    keys = st.sampled_from([*required, *optional, "other"])
    spoilt = st.tuples(sane, keys, anything).map(lambda drawn: {**drawn[0], drawn[1]: drawn[2]})
    short = st.tuples(sane, keys).map(lambda drawn: {key: drawn[0][key] for key in drawn[0] if key != drawn[1]})
    return st.sampled_from([*[sane] * 18, spoilt, short]).flatmap(lambda chosen: chosen)


motion = {"position": vectors, "velocity": vectors, "angular_velocity": vectors} | {
    "orientation": st.lists(numbers, min_size=4, max_size=4)
}
diagonal = st.lists(st.sampled_from([1e-300, 1.0, 1.5, 1e300]), min_size=3, max_size=3).map(
    lambda abc: [[abc[0], 0.1, 0], [0.1, abc[1], 0], [0, 0, abc[2]]]
)
bodies = (
    table({"shape": st.just("box"), "size": vectors, "mass": numbers}, motion)
    | table(
        {
            "shape": st.just("rigid"),
            "inertia": diagonal,
            "points": st.lists(vectors, min_size=1, max_size=3),
            "mass": numbers,
        },
        motion,
    )
    | table({"shape": st.just("mesh"), "file": st.sampled_from(["fuzz.toml", "nowhere.stl"]), "mass": numbers}, {})
)
rays = table({"origin": vectors, "direction": vectors}, {})
landings = {"point": vectors, "vertex": st.integers(0, 8), "point_body": vectors, "ray": rays}
impulses = st.one_of(
    [
        table({**strength, landing: where}, {"time": numbers})
        for strength in ({"value": vectors}, {"magnitude": numbers, "direction": vectors}, {"magnitude": numbers})
        for landing, where in landings.items()
    ]
)
tethers = table({"vertex": st.integers(0, 8), "anchor": vectors, "stiffness": numbers}, {"damping": numbers})
documents = table(
    {"title": st.just("a"), "duration": numbers, "step": numbers, "samples": st.integers(1, 5), "body": bodies},
    {
        "gravity": vectors,
        "impulse": st.lists(impulses, max_size=3),
        "tether": st.lists(tethers, max_size=2),
        "drag": table({}, {"linear": numbers, "angular": numbers}),
        "floor": table({"stiffness": numbers}, {"height": numbers, "normal": vectors, "damping": numbers}),
    },
)


def toml(value: object) -> str:
    """Return a value as inline TOML."""
    match value:
        case dict():
            return "{" + ", ".join(f"{toml(key)} = {toml(item)}" for key, item in value.items()) + "}"
        case list():
            return "[" + ", ".join(map(toml, value)) + "]"
        case bool():
            return str(value).lower()
        case str():
            return json.dumps(value, ensure_ascii=False)
        case _:
            return repr(value)


def test_any_document_gives_a_scene_or_a_line(tmp_path):
    file = tmp_path / "fuzz.toml"
    read, lines = [], []

    @settings(max_examples=500, derandomize=True, deadline=None)
    @given(document=documents)
    def fuzz(document):
        text = "".join(f"{toml(key)} = {toml(value)}\n" for key, value in document.items())
        file.write_text(text, encoding="utf-8")
        try:
            read.append(read_scene(str(file)))
        except BadScene as refused:
            lines.append(str(refused))

    fuzz()
    assert all(line.isprintable() for line in lines)
    assert all(isinstance(scene, Scene) for scene in read)
    # Documents that are nearly all refused would try nothing beyond the first check.
    assert len(read) > 100
    assert len(lines) > 100
