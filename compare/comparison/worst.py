"""The worst throws of a scene that ran in parts, as scene files that are run alone."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tumble.compare.comparison.against_truth import Comparison

FOLDER = "worst"


def worst_scenes(comparison: Comparison, document: Mapping[str, Any], folder: Path) -> dict[str, str]:
    """Return scene files, each of one throw: those with the largest errors of each contestant.

    Parameters
    ----------
    comparison : of a scene; of one whose throws are all held at once there are none
    document : tables of the scene's file
    folder : where that file is: a mesh is named from there

    Returns
    -------
    text by name of the file, worst/SCENE-throw-NUMBER.toml
    """
    members = sorted({int(member) for one in comparison.ensemble for member in one.spread.worst})
    if not members:
        return {}
    import tomli_w

    body = dict(document["body"])
    if "file" in body:
        body["file"] = str((folder / body["file"]).resolve())
    name = comparison.scene.name
    return {
        f"{FOLDER}/{name}-throw-{member}.toml": tomli_w.dumps(
            {**document, "body": body, "ensemble": {**document["ensemble"], "member": member}}
        )
        for member in members
    }
