"""What a shard is: shard.json, which it writes when it is finished, beside the results of its tasks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from tumble.compare.run.digest import code_digest, digest
from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.execution import Shard
from tumble.compare.run.process.message import PREFIX, Malformed, frame, unpacked
from tumble.compare.run.provenance import Machine
from tumble.compare.run.status import Failure
from tumble.compare.run.task_cache import write_whole
from tumble.scenarios.files import plain_bytes
from tumble.scenarios.refusal import UserError

FORMAT, FILE, TASKS = "tumble shard 1", "shard.json", "tasks"


class BadShard(UserError):
    """Folders that cannot be merged; the message is the one line for the user."""


@dataclass(frozen=True)
class Recorded:
    """An engine as a shard had it: what it states, and the digest of a user's file."""

    info: EngineInfo | Failure
    source: str


@dataclass(frozen=True)
class Manifest:
    """What a shard is: words of the whole command, number and count, Tumble's code, where it ran, and its engines."""

    format: str
    words: tuple[str, ...]
    number: int
    count: int
    code: str
    machine: Machine
    engines: dict[str, Recorded]

    @property
    def versions(self) -> dict[str, str]:
        """What it ran, by name: Tumble's code, Python and the packages."""
        return {"Tumble's code": self.code, **{row.what: row.value for row in self.machine.versions}}


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Write what a shard is into its folder.  Raises OSError."""
    (data,) = frame(manifest)
    write_whole(folder / FILE, bytes(data[PREFIX.size :]) + b"\n")


def read_manifest(folder: Path) -> Manifest:
    """Return what a shard is.

    Parameters
    ----------
    folder : of its results

    Returns
    -------
    its number, command, versions and engines

    Raises
    ------
    BadShard : the folder is not that of a finished shard
    """
    path = folder / FILE
    try:
        found = unpacked(Manifest, plain_bytes(path), b"")
    except FileNotFoundError:
        what = "it has no shard.json, which a shard writes when it is finished" if folder.is_dir() else "no such folder"
        raise BadShard(f"{folder}: not the results of a shard: {what}") from None
    except (OSError, Malformed) as error:
        raise BadShard(f"{path}: cannot be read: {error}") from None
    if found.format != FORMAT:
        raise BadShard(f"{path}: format {found.format!r}: this Tumble reads {FORMAT!r}")
    return found


def read_manifests(folders: Sequence[Path]) -> list[Manifest]:
    """Return what the shards of one command are, of the same versions and engines as this Tumble.  Raises BadShard."""
    found = [read_manifest(folder) for folder in folders]
    for folder, other in zip(folders[1:], found[1:], strict=True):
        refuse_mixed(folders[0], found[0], folder, other)
    if found[0].code != code_digest():
        raise BadShard(f"{folders[0]}: another version of Tumble ran this shard: merge with the version that ran it")
    return found


def refuse_mixed(folder: Path, one: Manifest, other_folder: Path, other: Manifest) -> None:
    """Raise BadShard where two shards are not of one command, of the same versions and engines."""
    if one.words != other.words:
        raise BadShard(f"{other_folder} ran `{' '.join(other.words)}`, but {folder} ran `{' '.join(one.words)}`")
    if one.count != other.count:
        numbers = [Shard(each.number, each.count) for each in (other, one)]
        raise BadShard(f"{other_folder} is shard {numbers[0]}, but {folder} is shard {numbers[1]}")
    for what in dict.fromkeys(chain(one.versions, other.versions)):
        here, there = (each.versions.get(what, "none") for each in (one, other))
        if here != there:
            raise BadShard(
                f"{other_folder} ran {what} {there}, but {folder} {here}: run all shards with the same versions"
            )
    for name in sorted(one.engines.keys() & other.engines.keys()):
        if digest(one.engines[name]) != digest(other.engines[name]):
            raise BadShard(f"{other_folder} and {folder} ran different engines under the name {name}")


def missing_shards(manifests: Sequence[Manifest]) -> str:
    """Return what to give beside these shards of one command, '' if that is all of them."""
    given = {one.number for one in manifests}
    count = manifests[0].count
    missing = [str(Shard(number, count)) for number in range(1, count + 1) if number not in given]
    return f"give {'shard' if len(missing) == 1 else 'shards'} {', '.join(missing)} too" if missing else ""


def together(machines: Sequence[Machine]) -> Machine:
    """Return the machines of all shards as one, with what differs side by side."""

    def joined(values: Iterator[str]) -> str:
        return "; ".join(sorted(set(values)))

    return replace(
        machines[0],
        processor=joined(each.processor for each in machines),
        cores=joined(each.cores for each in machines),
        system=joined(each.system for each in machines),
    )
