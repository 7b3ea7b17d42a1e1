"""CITATION.cff is valid by the format's own schema, and agrees with the package."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest
import yaml

ROOT = Path(__file__).parents[2]
# Citation File Format 1.2.0 (Druskat et al., 2021, doi 10.5281/zenodo.5171937), CC BY 4.0, as cffconvert has it.
SCHEMA = json.loads(Path(__file__).with_name("cff-1.2.0.schema.json").read_text(encoding="utf-8"))
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_it_is_valid():
    jsonschema.validate(CITATION, SCHEMA)


@pytest.mark.parametrize("change", [{"authors": []}, {"license": "none of these"}, {"cff-version": "9"}, {"colour": 1}])
def test_the_schema_refuses_what_is_wrong(change):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**CITATION, **change}, SCHEMA)


def test_it_agrees_with_the_package():
    stated = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (CITATION["version"], CITATION["license"]) == (stated["version"], stated["license"])
    assert set(CITATION["keywords"]) <= set(stated["keywords"])
    assert "The Tumble authors" in (ROOT / "LICENSE").read_text(encoding="utf-8")
