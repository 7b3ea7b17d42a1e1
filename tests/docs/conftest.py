"""The site as `make docs` builds it, made once by whichever process of the tests comes first."""

import fcntl
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def site(tmp_path_factory) -> Path:
    """The folder of the built site."""
    if importlib.util.find_spec("sphinx") is None:
        pytest.skip("the site needs `make venv-docs`")
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "site"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "done").exists():
            # What is read of the sources is that of `make docs`; the site itself is new.
            read = ROOT / "report" / "site-doctrees"
            words = ["-b", "html", "-W", "--keep-going", "-q", "-c", "tools/site", "-d", read, "docs"]
            command = [sys.executable, "-m", "sphinx", *words, folder / "html"]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=4 * PATIENCE_S)
            assert done.returncode == 0, done.stdout + done.stderr
            (folder / "done").touch()
    return folder / "html"
