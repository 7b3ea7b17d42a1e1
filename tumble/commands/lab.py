"""`tumble lab`: click the die in a browser."""

import signal
import sys
import threading
import webbrowser
from argparse import Namespace
from pathlib import Path

from tumble.notes import note

# Whose answers are held against the truth unless others are asked for.
USUAL = ("tumble", "pybullet", "mujoco:euler", "mujoco:rk4")


def main(options: Namespace) -> int:
    """Serve the lab until Ctrl-C."""
    try:
        from tumble.lab.server import serving
    except ImportError as error:
        if error.name not in ("viser", "tomlkit"):
            raise
        note("the lab needs viser: `make lab`, or, in Tumble's checkout, pip install '.[lab]'")
        return 2
    from tumble.lab.crew import Crew
    from tumble.lab.draft import Draft

    draft = Draft.opened(options.scene)
    with Crew(options.time_limit) as crew:
        contestants = crew.ready(options.engine or USUAL)
        with serving(draft, contestants, crew, Path.cwd(), options.port) as address:
            sys.stdout.write(f"{address}\n")
            sys.stdout.flush()
            note("Ctrl-C ends the lab")
            if options.open:
                webbrowser.open(address)
            stop = threading.Event()
            signal.signal(signal.SIGTERM, lambda *_: stop.set())
            try:
                stop.wait()
            except KeyboardInterrupt:
                note("the lab is closed")
    return 0
