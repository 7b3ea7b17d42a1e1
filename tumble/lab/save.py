"""The files of a throw, in the folder that the lab was started in; no file is ever overwritten."""

import io
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import frame, write_tables
from tumble.compare.tables.runs import run_row
from tumble.compare.tables.shared import RUNS
from tumble.compare.tables.trajectory import trajectory_text
from tumble.compare.tables.vertices import vertex_error_table
from tumble.lab.draft import Draft
from tumble.lab.pool import Contestant
from tumble.lab.throw import Throw
from tumble.scenarios.read import read_scene


class Saved:
    """The files of one throw.  Its scene file is always saved too; the other files are named after it.

    folder: where.  Its methods raise OSError.
    """

    def __init__(self, draft: Draft, folder: Path) -> None:
        self._draft, self._folder = draft, folder
        self._scene_file: Path | None = None

    @property
    def scene_file(self) -> Path:
        """The scene file, written when it is first asked for, and with it the mesh of its body."""
        if self._scene_file is None:
            path = unused(self._folder, self._draft.path.stem)
            mesh = self._draft.mesh
            beside = None if mesh is None else path.with_suffix(mesh.suffix)
            if mesh is not None and beside is not None:
                shutil.copyfile(mesh, beside)
            write_whole(path, self._draft.named(path, beside.name if beside else None).text)
            self._scene_file = path
        return self._scene_file

    @property
    def scene_files(self) -> list[Path]:
        """The scene file and what it needs beside it: the mesh of its body."""
        mesh = self._draft.mesh
        return [self.scene_file, *([] if mesh is None else [self.scene_file.with_suffix(mesh.suffix)])]

    def tables(self, throw: Throw) -> Path:
        """Write every trajectory as `tumble run` does and the errors as `tumble compare` does; return their folder."""
        scene = read_scene(str(self.scene_file))
        comparison = throw.comparison(scene)
        texts = {
            f"trajectory-{plain_name(one)}.csv": trajectory_text(flight, scene.body)
            for one, flight in throw.trajectories().items()
        }
        folder = self.scene_file.with_suffix("")
        write_tables(folder, error_tables(comparison), texts)
        return folder

    def report(self, contestants: Sequence[Contestant]) -> subprocess.Popen[str]:
        """Let `tumble report` make the page of this scene, beside it; return the command at work."""
        engines = [word for one in contestants for word in ("-e", f"{one.engine}:{one.method}")]
        words = ["report", self.scene_file.name, *engines, "-o", self.report_file.name]
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "tumble", *words],
            cwd=self._folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    @property
    def report_file(self) -> Path:
        """Where the report goes."""
        return self.scene_file.with_suffix(".html")

    def picture(self, png: bytes) -> Path:
        """Write a picture; several of one throw are numbered."""
        number = 1
        while (path := self.scene_file.with_name(f"{self.scene_file.stem}-picture-{number}.png")).exists():
            number += 1
        path.write_bytes(png)
        return path


def download(path: Path, files: Sequence[Path]) -> tuple[str, bytes]:
    """Return the name and the content of the download for a saved path: one file, or a ZIP
    archive of several.  Raises OSError."""
    if list(files) == [path]:
        return path.name, path.read_bytes()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files:
            archive.write(file, file.name)
    return f"{path.stem}.zip", out.getvalue()


def unused(folder: Path, stem: str) -> Path:
    """Reserve NAME-1.toml, or the next number of which nothing is there yet, and return it."""
    number = 1
    while True:
        path = folder / f"{stem}-{number}.toml"
        if not any(folder.glob(f"{glob_escape(path.stem)}*")):
            try:
                path.open("x").close()
            except FileExistsError:
                pass
            else:
                return path
        number += 1


def glob_escape(text: str) -> str:
    """Return a text that a pattern takes as it is."""
    return re.sub(r"([*?[])", r"[\1]", text)


def plain_name(contestant: Contestant) -> str:
    """Return a contestant's name as a part of a file's name."""
    return re.sub(r"[^\w.+@-]", "-", contestant.name)


def error_tables(comparison: Comparison) -> dict[str, pd.DataFrame]:
    """Return the tables of errors by file name."""
    return {
        "vertex-errors.csv": vertex_error_table(comparison.runs),
        "runs.csv": frame(RUNS, map(run_row, comparison.runs)),
    }
