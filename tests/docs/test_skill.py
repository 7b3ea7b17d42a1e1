"""The skill for coding agents: its commands run as printed, in an empty folder, one after the other."""

import os
import re
import subprocess
import sys
from pathlib import Path

from patience import PATIENCE_S

from tumble.compare.grade import grade
from tumble.compare.run.status import Status
from tumble.parser import parser

SKILL = Path(__file__).parents[2] / "skills/verify-an-engine/SKILL.md"
TEXT = SKILL.read_text(encoding="utf-8")
BLOCKS = re.findall(r"^ *```sh\n(.*?)^ *```", TEXT, re.MULTILINE | re.DOTALL)


def test_it_is_short_and_has_the_head_that_agents_read():
    assert len(TEXT.splitlines()) <= 100
    head = re.match(r"---\nname: ([a-z-]+)\ndescription: (.+)\n---\n", TEXT)
    assert head
    assert head[1] == SKILL.parent.name
    assert len(head[2]) <= 1024


def test_every_command_of_its_table_is_one_that_there_is():
    named = re.findall(r"\| `tumble (.+?)` \|", TEXT)
    assert len(named) > 8
    for words in named:
        parser().parse_args(words.split())


def test_it_names_every_verdict_and_every_status():
    verdicts = {value for name, value in vars(grade).items() if name.isupper() and isinstance(value, str)}
    assert len(verdicts) > 8
    assert {verdict for verdict in verdicts if verdict.removeprefix("correct ") not in TEXT} == set()
    assert {status for status in Status if f"`{status}`" not in TEXT} <= {Status.UNTIMED}


def test_its_blocks_run_as_printed_one_after_the_other(tmp_path):
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command in "".join(BLOCKS).splitlines():
        done = subprocess.run(
            command.split(),
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            timeout=2 * PATIENCE_S,
        )
        assert done.returncode == 0, (command, done.stderr)
        assert all((tmp_path / name).exists() for name in re.findall(r"-o (\S+)", command))
