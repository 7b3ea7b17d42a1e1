"""What a scene file may hold, made from its types: a JSON Schema for editors, and a table of keys for readers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import msgspec
from msgspec import inspect

from tumble.scenarios import format as scene_format
from tumble.scenarios.format import BodyTable, BoxTable, DiscTable, File, MeshTable, RayTable, RigidTable, SphereTable

# The tables in the order in which a file has them, and how their heads are written.
TABLES: dict[str, type] = {
    "": File,
    "[body]": BodyTable,
    '[body], shape = "box"': BoxTable,
    '[body], shape = "disc"': DiscTable,
    '[body], shape = "mesh"': MeshTable,
    '[body], shape = "rigid"': RigidTable,
    '[body], shape = "sphere"': SphereTable,
    "[[impulse]]": scene_format.ImpulseTable,
    "ray = { ... } of an [[impulse]]": RayTable,
    "[[tether]]": scene_format.TetherTable,
    "[drag]": scene_format.DragTable,
    "[floor]": scene_format.FloorTable,
    "[plane]": scene_format.PlaneTable,
    "[[sensor]]": scene_format.SensorTable,
    "[ensemble]": scene_format.EnsembleTable,
}


@dataclass(frozen=True)
class Key:
    """One key of a table: what it must be, its unit, what it means; default: as TOML, None where it must be there."""

    name: str
    allowed: str
    unit: str
    meaning: str
    default: str | None


def keys(table: type) -> Iterator[Key]:
    """Yield the keys of a table that hold values, not further tables; of a shape those that not every body has."""
    shared = BodyTable.__struct_fields__ if issubclass(table, BodyTable) and table is not BodyTable else ()
    for field in inspect.type_info(table).fields:  # type: ignore[attr-defined]
        if field.name in shared:
            continue
        said = next((said for said in _said(field.type) if "meaning" in said), None)
        if said:
            default = None if field.required else _as_toml(field.default)
            yield Key(field.name, said["description"], said["unit"], said["meaning"], default)


def _said(kind: Any) -> Iterator[dict[str, Any]]:
    """Yield what the annotations of a type say, also those of its alternatives."""
    if isinstance(kind, inspect.Metadata):
        yield kind.extra_json_schema or {}
    elif isinstance(kind, inspect.UnionType):
        for one in kind.types:
            yield from _said(one)


def _as_toml(default: object) -> str:
    """Return a default as a file would have it; nothing for what is then not there."""
    if default is None or default == "":
        return ""
    return str(list(default)) if isinstance(default, tuple) else str(default)


def title(table: type) -> str:
    """Return what a table is, in one line."""
    return (table.__doc__ or "").partition("\n")[0]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a scene file, for editors that complete and check TOML by one."""
    schema = msgspec.json.schema(File)
    for definition in schema["$defs"].values():
        for name, member in definition.get("properties", {}).items():
            definition["properties"][name] = _for_editors(member)
        definition.pop("title", None)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "A scene of Tumble", **schema}


def _for_editors(member: dict[str, Any]) -> dict[str, Any]:
    """Return a key's schema with meaning and unit in its description; a key that may be absent is not null in TOML."""
    alternatives = [one for one in member.get("anyOf", ()) if one.get("type") != "null"]
    if len(alternatives) == 1:
        member = {**alternatives[0]}
    if "meaning" in member:
        meaning, unit, allowed = member.pop("meaning"), member.pop("unit"), member.pop("description")
        member["description"] = f"{meaning}{f' [{unit}]' if unit else ''}: {allowed}"
    if member.get("default", "") is None:
        del member["default"]
    return member
