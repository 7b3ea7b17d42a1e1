"""The JSON Schema and the tables of keys are what the types say, and a schema refuses what the reader refuses."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from tools import scene_guide
from tumble.scenarios.read import CATALOGUE, catalogue
from tumble.scenarios.schema import TABLES, json_schema, keys

ROOT = Path(__file__).parents[2]


def test_the_guide_and_the_schema_are_what_the_script_makes():
    guide = (ROOT / "docs/scene.md").read_text(encoding="utf-8")
    assert scene_guide.page(guide) == guide, "run: python -m tools.scene_guide"
    assert (ROOT / "docs/scene.schema.json").read_text(encoding="utf-8") == scene_guide.schema_text(), (
        "python -m tools.scene_guide"
    )


def test_every_key_has_a_meaning_and_the_guide_has_every_key():
    guide = (ROOT / "docs/scene.md").read_text(encoding="utf-8")
    for table in TABLES.values():
        for name in table.__struct_fields__:
            assert f"`{name}`" in guide or f"[{name}]" in guide or f"{name} = " in guide, name
        for key in keys(table):
            assert key.meaning


@pytest.mark.parametrize("name", catalogue())
def test_the_catalogue_is_valid(name):
    jsonschema.validate(tomllib.loads((CATALOGUE / f"{name}.toml").read_text(encoding="utf-8")), json_schema())


# What only types can see; the rest of tests/bad takes geometry and physics.
SEEN = (
    "mass-zero", "mass-string", "mass-missing", "key-top", "key-body", "key-impulse", "shape-unknown", "samples-zero",
    "tether-damping-negative", "vertex-negative", "orientation-short", "size-flat", "gravity-a-number",
)  # fmt: skip


@pytest.mark.parametrize("name", SEEN)
def test_what_is_refused_by_type_is_refused_by_the_schema(name):
    document = tomllib.loads((ROOT / f"tests/bad/{name}.toml").read_text(encoding="utf-8"))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, json_schema())


def test_no_key_may_be_null_for_toml_has_no_null():
    assert "null" not in json.dumps(json_schema())
