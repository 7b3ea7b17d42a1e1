"""The one place that runs Tumble: its commands, and what of their answers is read.

Only `tumble scenes NAME` and `tumble grade FILE --scene FILE --json` are used, so that processor times are those of
the command as a user has it.
"""

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryFile

TUMBLE = (sys.executable, "-m", "tumble")
# Verdicts, by how they begin.
CORRECT, FIRM, PARTLY = "correct", "explained", "explained in part"


@dataclass(frozen=True)
class Claim:
    """One mistake of an explanation: its name and its parameters, as text."""

    name: str
    parameters: Mapping[str, str] = field(default_factory=dict)

    def number(self, *names: str) -> float | None:
        """Return the first parameter of these names that is a number."""
        for name in names:
            try:
                return float(self.parameters[name])
            except (KeyError, ValueError):
                continue
        return None

    def __str__(self) -> str:
        values = ", ".join(value for value in self.parameters.values() if value)
        return f"{self.name} ({values})" if values else self.name


@dataclass(frozen=True)
class Answer:
    """What `tumble grade` answered: explanations, the best first and then those that fit alike; cpu_s: of the process.

    max_error_m: how far off the file is; residual_m: how far by its best explanation; confidence: None where it has
    none; failure: what it wrote where it did not answer.
    """

    verdict: str
    explanations: Sequence[Sequence[Claim]]
    engines: Sequence[str]
    confidence: float | None
    max_error_m: float
    residual_m: float | None
    cpu_s: float
    failure: str = ""

    @property
    def is_correct(self) -> bool:
        """Whether the file is called correct."""
        return self.verdict.startswith(CORRECT)

    @property
    def is_firm(self) -> bool:
        """Whether the file is called explained."""
        return self.verdict == FIRM

    @property
    def best(self) -> Sequence[Claim]:
        """The claims that are made: of a file that is explained, or explained in part."""
        return self.explanations[0] if self.verdict in (FIRM, PARTLY) and self.explanations else ()


def scene_text(name: str) -> str:
    """Return a scene of the catalogue as TOML."""
    return subprocess.run([*TUMBLE, "scenes", name], check=True, capture_output=True, text=True).stdout


def asked(file: Path, scene: Path, options: Sequence[str]) -> dict:
    """Return what `tumble grade` says of a file, as JSON, with its processor time; `failure` where it says nothing."""
    words = [*TUMBLE, "grade", str(file), "--scene", str(scene), "--json", *options]
    with TemporaryFile() as out, TemporaryFile() as errors:
        process = subprocess.Popen(words, stdout=out, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        errors.seek(0)
        said, complaint = out.read(), errors.read().decode(errors="replace")
    cpu_s = usage.ru_utime + usage.ru_stime
    if process.returncode:
        return {"failure": f"exit {process.returncode}: {complaint.strip()[-300:]}", "cpu_s": cpu_s}
    return json.loads(said) | {"cpu_s": cpu_s}


def graded(file: Path, scene: Path, options: Sequence[str]) -> Answer:
    """Return the answer of `tumble grade` to a file."""
    return answer_of(asked(file, scene, options))


def answer_of(said: Mapping) -> Answer:
    """Return the answer in the JSON of `tumble grade`."""
    cpu_s = float(said.get("cpu_s", 0.0))
    if "failure" in said:
        return Answer("", (), (), None, 0.0, None, cpu_s, said["failure"])
    ranks: dict[int, list[dict]] = {}
    for row in said["diagnosis"]:
        if row["mistake"]:
            ranks.setdefault(int(row["rank"]), []).append(row)
    explanations = [list(_claims(rows)) for _, rows in sorted(ranks.items())]
    best = ranks.get(1, [])
    confidence = said.get("confidence", best[0].get("confidence") if best else None)
    left = float(best[0]["residual_m"]) if best else None
    number = None if confidence in (None, "") else float(confidence)
    return Answer(said["verdict"], explanations, said["engines"], number, float(said["max_error_m"]), left, cpu_s)


def _claims(rows: Sequence[Mapping]) -> list[Claim]:
    """Return the claims in rows of one explanation: rows of one name are of one claim until a parameter comes again."""
    found: list[Claim] = []
    for row in rows:
        name, parameter = row["mistake"], row["parameter"]
        if not found or found[-1].name != name or parameter in found[-1].parameters:
            found.append(Claim(name, {}))
        found[-1] = Claim(name, {**found[-1].parameters, parameter: row["value"]})
    return found
