"""Scenes as Python values: what a scene file says, made, changed and written back without a file."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd
import tomli_w

from tumble.scenarios.format import BODY_KEYS
from tumble.scenarios.needs import needs
from tumble.scenarios.read import BadScene, catalogue, contact_catalogue, read_document, scene_of_document, scene_path
from tumble.scenarios.scene import Scene as Question

# A step [s] that is short for a body that tumbles a few times a second; it is also MuJoCo's default.
STEP = 0.002


@dataclass(frozen=True, repr=False, eq=False)
class Scene:
    """One question for every engine: a body, its start, what acts on it, and when it is sampled.

    Make one with `Scene.box`, `Scene.sphere`, `Scene.rigid` or `Scene.mesh`, from a table as in TOML with
    `Scene.from_dict`, or from a name or a file with `Scene.read`.  Scenes do not change: `replace`, `with_impulse`,
    `with_tether` and `with_sensor` return new ones.

    Parameters
    ----------
    document : the tables of a scene file (docs/scene.md), SI units, vectors in world axes.
    name : the scene's name in tables.
    folder : where the file of a mesh is looked up.

    Raises
    ------
    UserError
        For a value that no scene may have; the message names the key, the value and what is allowed.
    """

    document: Mapping[str, Any]
    name: str = "scene"
    folder: Path = field(default_factory=Path, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "document", plain(self.document))
        if not self.name or not self.name.isprintable() or any(letter in self.name for letter in "/\\"):
            raise BadScene(f"name = {self.name!r}: must be printable text without / and \\")
        _ = self.question  # refused here, at the line that made it

    @classmethod
    def box(cls, size: Sequence[float], mass: float, **values: Any) -> Self:
        """Return the scene of a box.

        Parameters
        ----------
        size : full edges [m], (3,).
        mass : [kg].
        **values : any other key of a scene file or of its [body] (`duration`, `samples`, `gravity`, `velocity` ...),
            and `name`.  `step` is 0.002 s unless it is given.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.box(size=(0.4, 0.15, 0.1), mass=2.4, duration=2.0, samples=80).document["step"]
        0.002
        """
        return cls._of_shape("box", values, size=size, mass=mass)

    @classmethod
    def sphere(cls, radius: float, mass: float, **values: Any) -> Self:
        """Return the scene of a uniform sphere.

        Parameters
        ----------
        radius : [m].
        mass : [kg].
        **values : as `Scene.box` has them.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.sphere(0.1, 1.0, duration=1.0, samples=2).question.body.moments.round(6).tolist()
        [0.004, 0.004, 0.004]
        """
        return cls._of_shape("sphere", values, radius=radius, mass=mass)

    @classmethod
    def disc(cls, radius: float, mass: float, thickness: float = 0.0, **values: Any) -> Self:
        """Return the scene of a uniform disc about the body's z axis.

        Parameters
        ----------
        radius : [m].
        mass : [kg].
        thickness : along z [m]; 0: the limit of a thin disc.
        **values : as `Scene.box` has them.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.disc(0.1, 1.0, duration=1.0, samples=2).question.body.moments.round(6).tolist()
        [0.0025, 0.0025, 0.005]
        """
        return cls._of_shape("disc", values, radius=radius, thickness=thickness, mass=mass)

    @classmethod
    def rigid(
        cls, inertia: Sequence[Sequence[float]], points: Sequence[Sequence[float]], *, mass: float, **values: Any
    ) -> Self:
        """Return the scene of a body that is given by its inertia tensor.

        Parameters
        ----------
        inertia : about the centre of mass [kg m2], (3, 3).
        points : compared as vertices, from the centre of mass [m], (n, 3).
        mass : [kg].
        **values : as `Scene.box` has them.

        Returns
        -------
        Scene

        Examples
        --------
        >>> tensor, corners = [[1, 0, 0], [0, 2, 0], [0, 0, 2.5]], [[0.5, 0, 0], [0, 0.5, 0]]
        >>> Scene.rigid(tensor, corners, mass=1.0, duration=1.0, samples=2)
        <tumble.Scene 'rigid': rigid of 1 kg, 1 s>
        """
        return cls._of_shape("rigid", values, inertia=inertia, points=points, mass=mass)

    @classmethod
    def mesh(cls, file: str | Path, mass: float, **values: Any) -> Self:
        """Return the scene of a closed mesh of even density.

        Parameters
        ----------
        file : STL, OBJ, PLY or OFF, in metres.
        mass : [kg].
        **values : as `Scene.box` has them.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.mesh("die.stl", 1.0, duration=1.0, samples=2)
        Traceback (most recent call last):
            ...
        tumble.scenarios.read.BadScene: mesh: body.file = 'die.stl': no such file
        """
        path = Path(file)
        return cls._of_shape("mesh", {"folder": path.parent, **values}, file=path.name, mass=mass)

    @classmethod
    def _of_shape(cls, shape: str, values: dict[str, Any], **body: Any) -> Self:
        given = {"name": shape, "title": values.get("name", shape), "step": STEP, **values}
        name, folder = given.pop("name"), given.pop("folder", Path())
        return cls(placed({"body": {"shape": shape, **body}}, given), name, folder=folder)

    @classmethod
    def read(cls, name_or_path: str | Path) -> Self:
        """Return a scene of the catalogue, or the one in a TOML file.

        Parameters
        ----------
        name_or_path : as on the command line.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.read("brick-tumble").name
        'brick-tumble'
        """
        path = scene_path(str(name_or_path))
        return cls(read_document(path, str(name_or_path)), path.stem, folder=path.parent)

    @classmethod
    def from_dict(cls, document: Mapping[str, Any], name: str = "scene", *, folder: str | Path = ".") -> Self:
        """Return the scene that a table as in TOML describes.

        Parameters
        ----------
        document : keys and tables of a scene file; arrays may be numpy's.
        name : the scene's name in tables.
        folder : where the file of a mesh is looked up.

        Returns
        -------
        Scene

        Examples
        --------
        >>> body = {"shape": "box", "size": [1, 2, 3], "mass": 1}
        >>> Scene.from_dict({"title": "A box", "duration": 1.0, "samples": 2, "step": 0.01, "body": body}, "mine")
        <tumble.Scene 'mine': box of 1 kg, 1 s>
        """
        return cls(document, name, folder=Path(folder))

    @classmethod
    def of(cls, scene: "SceneLike") -> "Scene":
        """Return a scene as a `Scene`.

        Parameters
        ----------
        scene : a name, a path, a table as in TOML, or a `Scene`.

        Returns
        -------
        Scene

        Raises
        ------
        UserError
            For what is none of these.

        Examples
        --------
        >>> Scene.of("two-hits") == Scene.read("two-hits")
        True
        """
        if isinstance(scene, Scene):
            return scene
        if isinstance(scene, Mapping):
            return cls.from_dict(scene)
        if isinstance(scene, str | Path):
            return cls.read(scene)
        raise BadScene(f"{scene!r}: must be a scene's name, a path, a table as in TOML, or a tumble.Scene")

    def replace(self, **changes: Any) -> Self:
        """Return the scene with other values.

        Parameters
        ----------
        **changes : keys of a scene file or of its [body], and `name`; None removes a key.  `times` replaces
            `samples`, and the other way round.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.read("brick-tumble").replace(mass=5.0, name="heavy").question.body.mass
        5.0
        """
        name = changes.pop("name", self.name)
        document = dict(self.document)
        for one, other in (("times", "samples"), ("samples", "times")):
            if changes.get(one) is not None:
                document.pop(other, None)
        return type(self)(placed(document, changes), name, folder=self.folder)

    def with_impulse(self, value: Sequence[float] | None = None, **where: Any) -> Self:
        """Return the scene with one more impulse.

        Parameters
        ----------
        value : impulse [N s], (3,), world axes; or `magnitude` [N s] and `direction` instead.
        **where : one of `vertex`, `point` [m, world axes], `point_body` [m, body axes] and `ray`; and `time` [s],
            0 by default.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.read("brick-tumble").with_impulse((0, 0, 1), vertex=0, time=0.5).document["impulse"]
        [{'value': [0, 0, 1], 'vertex': 0, 'time': 0.5}]
        """
        return self._with("impulse", {"value": value, **where})

    def with_tether(self, vertex: int, anchor: Sequence[float], *, stiffness: float, **values: Any) -> Self:
        """Return the scene with one more tether, a spring and damper from a vertex to a fixed point.

        Parameters
        ----------
        vertex : of the body.
        anchor : fixed point [m], (3,), world axes.
        stiffness : [N/m].
        **values : `damping` [N s/m], `rest_length` [m].

        Returns
        -------
        Scene

        Examples
        --------
        >>> scene = Scene.read("brick-tumble").with_tether(0, (0, 2, 0), stiffness=80.0)
        >>> scene.document["tether"][0]["stiffness"]
        80.0
        """
        return self._with("tether", {"vertex": vertex, "anchor": anchor, "stiffness": stiffness, **values})

    def with_sensor(self, name: str, kind: str = "imu", *, rate: float, **values: Any) -> Self:
        """Return the scene with one more sensor, fixed to the body.

        Parameters
        ----------
        name : of the sensor, unique in the scene.
        kind : imu, accelerometer, gyro or magnetometer-direction.
        rate : readings per second [Hz].
        **values : `point` [m, body axes], `orientation` (w x y z, sensor to body), `average`, `field`.

        Returns
        -------
        Scene

        Examples
        --------
        >>> Scene.read("two-hits").with_sensor("imu", rate=100.0, point=(0.2, 0.0, 0.0)).question.sensors[0].rate
        100.0
        """
        return self._with("sensor", {"name": name, "kind": kind, "rate": rate, **values})

    def _with(self, kind: str, table: dict[str, Any]) -> Self:
        given = {key: value for key, value in table.items() if value is not None}
        return self.replace(**{kind: [*self.document.get(kind, []), given]})

    def to_dict(self) -> dict[str, Any]:
        """Return the tables of the scene's file.

        Returns
        -------
        dict
            As `tomllib` reads the file; changing it does not change the scene.

        Examples
        --------
        >>> Scene.read("brick-tumble").to_dict()["body"]["shape"]
        'box'
        """
        return plain(self.document)

    def to_toml(self) -> str:
        """Return the text of the scene's file.

        Returns
        -------
        str
            TOML that `tumble` reads back as this scene, bit for bit.

        Examples
        --------
        >>> print(Scene.sphere(0.1, 1.0, duration=1.0, samples=2).to_toml().splitlines()[0])
        title = "sphere"
        """
        return tomli_w.dumps(self.to_dict())

    @cached_property
    def question(self) -> Question:
        """The scene as engines receive it.

        Returns
        -------
        tumble.scenarios.scene.Scene
        """
        return self._in_parts if self._in_parts.ensemble is None else self._read(in_parts=False)

    @cached_property
    def _in_parts(self) -> Question:
        return self._read(in_parts=True)

    def _read(self, in_parts: bool) -> Question:
        return scene_of_document(self.to_dict(), self.folder / f"{self.name}.toml", self.name, in_parts=in_parts)

    def __repr__(self) -> str:
        body = self.document["body"]
        return f"<tumble.Scene {self.name!r}: {body['shape']} of {body['mass']:g} kg, {self.document['duration']:g} s>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return (self.document, self.name) == (other.document, other.name)

    def __hash__(self) -> int:
        return hash((self.name, self.to_toml()))


SceneLike = Scene | str | Path | Mapping[str, Any]
Scenes = SceneLike | Iterable[SceneLike]


def questions(scenes: Scenes) -> list[Question]:
    """Return scenes as engines receive them, each with a name of its own (`named_scenes`).

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.

    Returns
    -------
    list of tumble.scenarios.scene.Scene

    Raises
    ------
    UserError
        For a scene that cannot be read, and where none is given.
    """
    return [scene.question for scene in named_scenes(scenes)]


def named_scenes(scenes: Scenes) -> list[Scene]:
    """Return scenes, each with a name of its own.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.  Of two different scenes with one name
        the second is called NAME-2: they are two scenes in every table.

    Returns
    -------
    list of Scene

    Raises
    ------
    UserError
        For a scene that cannot be read, and where none is given.
    """
    one = isinstance(scenes, Scene | str | Path | Mapping) or not isinstance(scenes, Iterable)
    several: Iterable[Any] = [scenes] if one else scenes  # type: ignore[assignment]
    found: dict[Scene, str] = {}
    for scene in map(Scene.of, several):
        if scene not in found:
            names = (scene.name, *(f"{scene.name}-{number}" for number in range(2, len(found) + 3)))
            found[scene] = next(name for name in names if name not in found.values())
    if not found:
        raise BadScene("no scene was given")
    return [scene.replace(name=name) for scene, name in found.items()]


def in_parts(scene: Scene) -> Question:
    """Return a scene as engines receive it, for a study that runs very many throws in parts.

    Parameters
    ----------
    scene : its throws may be more than memory holds.

    Returns
    -------
    tumble.scenarios.scene.Scene
    """
    return scene._in_parts


def is_empty(scenes: Scenes) -> bool:
    """Return whether no scene was given, which asks for a function's default.

    Parameters
    ----------
    scenes : one or several, or an empty tuple or list.

    Returns
    -------
    bool
    """
    return isinstance(scenes, tuple | list) and not scenes


def placed(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with values changed, each where a scene file has its key; None removes one."""
    found = {**document, "body": dict(document["body"])}
    for key, value in changes.items():
        table = found["body"] if key in BODY_KEYS else found
        if value is None:
            table.pop(key, None)
        elif key == "body":
            found["body"] = dict(value)
        else:
            table[key] = value
    return found


def plain(value: Any) -> Any:
    """Return a value of tables, lists, numbers and text as TOML has them; arrays become lists."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def scenes() -> pd.DataFrame:
    """Return the catalogue.

    Returns
    -------
    pandas.DataFrame
        One row a scene: `scene`, `title`, `needs` (what an engine must have for it), `duration_s`, `step_s`.

    Examples
    --------
    >>> "brick-tumble" in set(scenes().scene)
    True
    """
    rows = [
        (name, one.title, ", ".join(needs(one)), one.duration, one.step)
        for name in [*catalogue(), *contact_catalogue()]
        for one in (Scene.read(name).question,)
    ]
    return pd.DataFrame(rows, columns=["scene", "title", "needs", "duration_s", "step_s"])
