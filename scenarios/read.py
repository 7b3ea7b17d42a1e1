"""From the name of a scene or its file (TOML) to a Scene, or to the one line that says what is wrong with it.

`tumble.scenarios.format` holds a file against keys, types and signs; `tumble.scenarios.build` checks what a type cannot
say, and builds.  Reading runs no code and opens no file but the scene and its mesh.
"""

import os
import tomllib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from tumble.scenarios.build import scene_from
from tumble.scenarios.files import plain_bytes, why_unread
from tumble.scenarios.format import Refused, dotted, nearest, printable, short, tables, value_at
from tumble.scenarios.refusal import UserError
from tumble.scenarios.scene import Scene

CATALOGUE = Path(__file__).parent / "catalogue"
# Scenes above a rigid plane: read by name, listed apart.
CONTACT = CATALOGUE / "contact"
EXTREMES = Path(__file__).parent / "extremes"


class BadScene(UserError):
    """A scene that cannot be read; its text is the one line to show."""


def catalogue() -> list[str]:
    """Return the names of the scenes in the catalogue.

    Returns
    -------
    names
        sorted
    """
    return sorted(path.stem for path in CATALOGUE.glob("*.toml"))


def contact_catalogue() -> list[str]:
    """Return the names of the catalogue's scenes above a rigid plane.

    Returns
    -------
    names
        sorted
    """
    return sorted(path.stem for path in CONTACT.glob("*.toml"))


def extremes() -> list[str]:
    """Return the names of the extreme cases: scenes with numbers near the limits, all with an exact truth.

    Returns
    -------
    names
        sorted
    """
    return sorted(path.stem for path in EXTREMES.glob("*.toml"))


def read_scene(name_or_path: str, to_run: bool = True, in_parts: bool = False) -> Scene:
    """Read a scene.

    Parameters
    ----------
    name_or_path
        name of a scene of the catalogue or of an extreme case, or the path of a TOML file (.toml, or with a
        separator)
    to_run
        whether the scene will be run, which needs a step and sample times
    in_parts
        whether very many throws will be run in parts; otherwise all are drawn at once

    Returns
    -------
    scene

    Raises
    ------
    BadScene
        The scene cannot be read; the message is one line with file, key, value and what is allowed.
    """
    path, shown = scene_path(name_or_path), printable(name_or_path)
    return scene_of(scene_text(path, shown), path, shown, to_run, in_parts)


def scene_of(text: str, path: Path, shown: str, to_run: bool = True, in_parts: bool = False) -> Scene:
    """Read a scene from a text.

    Parameters
    ----------
    text
        TOML
    path
        names the scene, and its folder is where its mesh is
    shown
        name of the file in error messages
    to_run, in_parts
        as in `read_scene`

    Returns
    -------
    scene

    Raises
    ------
    BadScene
    """
    return scene_of_document(_document(text, shown), path, shown, to_run, in_parts)


def scene_of_document(document: dict, path: Path, shown: str, to_run: bool = True, in_parts: bool = False) -> Scene:
    """Return the scene that the tables of a scene file describe.

    Parameters
    ----------
    document : tables as in TOML
    path : of the file; a mesh is looked up beside it
    shown : what refusals call the scene
    to_run : whether it needs a step and sample instants
    in_parts : whether very many throws will be run in parts

    Returns
    -------
    the scene

    Raises
    ------
    BadScene : a value is not allowed; the message names its key
    """
    try:
        # What overflows is refused by its result, not by a warning on the way.
        with np.errstate(all="ignore"):
            return scene_from(tables(document), path, to_run, in_parts)
    except Refused as refused:
        value = f" = {short(value_at(document, refused.keys))}" if refused.show_value else ""
        raise BadScene(f"{shown}: {dotted(refused.keys)}{value}: {refused.why}") from None


def read_scenes(names_or_paths: Iterable[str], in_parts: bool = False) -> list[Scene]:
    """Read scenes, each once.

    Parameters
    ----------
    names_or_paths
    in_parts
        as in `read_scene`

    Returns
    -------
    scenes

    Raises
    ------
    BadScene
        A scene cannot be read, or two files have the same name.
    """
    scenes = [read_scene(name, in_parts=in_parts) for name in dict.fromkeys(names_or_paths)]
    for number, scene in enumerate(scenes):
        if any(scene.name == other.name for other in scenes[:number]):
            raise BadScene(f"two scenes are named {scene.name!r}: rename one of the files")
    return scenes


def scene_path(name_or_path: str) -> Path:
    """Return the file of a scene.

    Parameters
    ----------
    name_or_path
        as in `read_scene`

    Returns
    -------
    path

    Raises
    ------
    BadScene
        No scene has that name.
    """
    if name_or_path.endswith(".toml") or any(sep in name_or_path for sep in (os.sep, os.altsep) if sep):
        return Path(name_or_path)
    folders = {CATALOGUE: catalogue(), CONTACT: contact_catalogue(), EXTREMES: extremes()}
    for folder, names in folders.items():
        if name_or_path in names:
            return folder / f"{name_or_path}.toml"
    every = [name for names in folders.values() for name in names]
    raise BadScene(f"unknown scene {short(name_or_path)}: {nearest(name_or_path, every)}")


def scene_text(path: Path, shown: str) -> str:
    """Return the text of a scene file.

    Parameters
    ----------
    path
    shown
        name of the file in error messages

    Returns
    -------
    text

    Raises
    ------
    BadScene
        The file cannot be read or is not UTF-8.
    """
    try:
        return plain_bytes(path).decode("utf-8-sig")
    except OSError as error:
        raise BadScene(f"{shown}: {why_unread(error)}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise BadScene(f"{shown}: not UTF-8 text (at line {line})") from None


def read_document(path: Path, shown: str) -> dict:
    """Return the tables of a scene file.

    Parameters
    ----------
    path : of the file
    shown : what refusals call the scene

    Returns
    -------
    tables as in TOML

    Raises
    ------
    BadScene : the file cannot be read or is not TOML
    """
    return _document(scene_text(path, shown), shown)


def _document(text: str, shown: str) -> dict:
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise BadScene(f"{shown}: not TOML: nested too deeply") from None
    except ValueError as error:  # besides TOMLDecodeError: an integer of thousands of digits
        raise BadScene(f"{shown}: not TOML: {printable(str(error))}") from None
