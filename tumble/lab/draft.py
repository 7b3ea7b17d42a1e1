"""The scene as it is being edited: a scene file's tables, the edits, and the scene that they make.

A throw runs the scene that is read back from the text that *Save scene* writes, so the two cannot differ.
"""

import copy
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
import tomlkit

from tumble.lab.clock import pace
from tumble.scenarios.format import visible
from tumble.scenarios.read import scene_of, scene_path, scene_text
from tumble.scenarios.scene import Scene

# Frames of a flight: per second of watching at its usual pace, and at most in all.
FRAMES_A_SECOND, MOST = 24, 600


@dataclass(frozen=True, eq=False)
class Draft:
    """The tables of a scene file, which may have been edited, and the file that they came from."""

    document: Mapping[str, Any]
    path: Path

    @classmethod
    def opened(cls, name_or_path: str) -> Self:
        """Return a scene of the catalogue or of a file, sampled once per frame.

        Parameters
        ----------
        name_or_path
            The name of a scene of the catalogue, or the path of a TOML file; of an ensemble only member 0 is taken.

        Raises
        ------
        BadScene
            There is no such scene, or it is not valid.
        """
        path = scene_path(name_or_path)
        text = scene_text(path, visible(name_or_path))
        scene_of(text, path, visible(name_or_path))
        document = {key: value for key, value in tomllib.loads(text).items() if key != "ensemble"}
        return cls(document, path)._with_frames()

    @cached_property
    def text(self) -> str:
        """The scene file."""
        file = tomlkit.document()
        for key, value in self.document.items():
            file.add(key, _item(value))
        return tomlkit.dumps(file)

    @cached_property
    def scene(self) -> Scene:
        """The scene that the text makes.  Raises BadScene."""
        return scene_of(self.text, self.path, self.path.stem)

    @property
    def brings_a_throw(self) -> bool:
        """Whether its file has impulses of its own, or a body that moves without one."""
        return bool(self.scene.impulses) or bool(self.scene.start[0, 7:].any())

    def edited(self, values: Mapping[tuple[str, ...], Any]) -> Self:
        """Return the draft with values set at paths of keys, ("body", "mass") one of them.  Raises BadScene."""
        document = copy.deepcopy(dict(self.document))
        for (*tables, key), value in values.items():
            table = document
            for name in tables:
                table = table.setdefault(name, {})
            table[key] = value
        # The instants are those of frames, which follow from the rest: those of before may lie beyond the end now.
        plain = {name: value for name, value in document.items() if name not in ("times", "samples")}
        return replace(self, document={**plain, "samples": 1})._with_frames()

    def without_impulses(self) -> Self:
        """Return the draft without impulses."""
        return replace(self, document={key: value for key, value in self.document.items() if key != "impulse"})

    def with_impulse(self, impulse: Mapping[str, Any]) -> Self:
        """Return the draft with one more impulse, the last to act.  Raises BadScene."""
        draft = replace(self, document={**self.document, "impulse": [*self.document.get("impulse", []), impulse]})
        _ = draft.scene
        return draft

    def named(self, path: Path, mesh: str | None = None) -> Self:
        """Return the draft as the file at that path, whose mesh, if it has one, is the file of that name beside it."""
        document = copy.deepcopy(dict(self.document))
        if mesh is not None:
            document["body"]["file"] = mesh
        return replace(self, document=document, path=path)

    @property
    def mesh(self) -> Path | None:
        """The file of the body's mesh, if it has one."""
        file = self.document["body"].get("file")
        return None if file is None else self.path.parent / file

    def _with_frames(self) -> Self:
        """Return the draft sampled once per frame instead of at its own instants."""
        scene = self.scene
        later = {impulse.time for impulse in scene.impulses} - {0.0}
        document = {key: value for key, value in self.document.items() if key not in ("times", "samples")}
        count = frames(scene.duration, scene.step)
        draft = replace(self, document={**document, "samples": count})
        if later <= set(draft.scene.times.tolist()):
            return draft
        # Impulses of the file's own that fall between frames are instants too.
        times = sorted({*draft.scene.times.tolist(), *later})
        return replace(self, document={**document, "times": times})


def frames(duration: float, step: float) -> int:
    """Return how many frames a flight is shown in: a whole number of steps [s] apart where that can be.

    Where no such number is near, steps are cut at the frames, as at any sample.  A flight of fewer steps is shown in
    these: a frame between steps would change the flight.
    """
    steps = round(duration / step)
    wanted = min(FRAMES_A_SECOND * duration / pace(duration), MOST)
    if steps <= wanted:
        return max(steps, 1)
    near = [count for count in range(round(wanted / 2), round(1.5 * wanted) + 1) if steps % count == 0]
    return min(near, key=lambda count: abs(math.log(count / wanted)), default=round(wanted))


def usual_magnitude(scene: Scene) -> float:
    """Return an impulse [N s] that suits a scene: its own throw's, or what moves the body by its size meanwhile."""
    if scene.impulses:
        return float(f"{np.linalg.norm(scene.impulses[0].value):.2g}")
    size = float(np.ptp(scene.body.points, axis=0).max())
    return float(f"{scene.body.mass * size / scene.duration:.1g}")


def _item(value: Any) -> Any:
    """Return a value as a person writes it: tables by their heads, a ray on one line."""
    if isinstance(value, Mapping):
        table = tomlkit.table()
        for key, member in value.items():
            if isinstance(member, Mapping):
                inline = tomlkit.inline_table()
                inline.update(member)
                table.add(key, inline)
            else:
                table.add(key, member)
        return table
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        tables = tomlkit.aot()
        for member in value:
            tables.append(_item(member))
        return tables
    return value
