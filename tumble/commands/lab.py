"""`tumble lab`: throw the die in a browser."""

import signal
import sys
import threading
import webbrowser
from argparse import Namespace
from pathlib import Path

from tumble.notes import display, note

# Contestants unless others are asked for.
USUAL = ("tumble", "pybullet", "mujoco:euler", "mujoco:rk4")


def main(options: Namespace) -> int:
    """Serve the lab until Ctrl-C."""
    try:
        from tumble.lab.pool import Pool
    except ImportError as error:
        return lacking(error)
    names = options.engine or USUAL
    with Pool(options.time_limit) as pool:
        engines = pool.begin(names)
        with display(options)(len(engines) + 1) as on_progress:
            on_progress("starting", 0.0)
            try:
                # Engines start in processes of their own while the server is imported here.
                from tumble.lab.draft import Draft
                from tumble.lab.server import serving
            except ImportError as error:
                return lacking(error)
            draft = Draft.opened(options.scene)
            on_progress("starting")
            contestants = pool.ready(names, on_progress)
        with serving(draft, contestants, pool, Path.cwd(), options.port) as address:
            sys.stdout.write(f"{address}\n")
            sys.stdout.flush()
            note("press Ctrl-C to stop the lab")
            if options.open:
                webbrowser.open(address)
            stop = threading.Event()
            signal.signal(signal.SIGTERM, lambda *_: stop.set())
            try:
                stop.wait()
            except KeyboardInterrupt:
                note("the lab was stopped")
    return 0


def lacking(error: ImportError) -> int:
    """Print what the lab needs that is not installed.  Raises any other error."""
    if error.name not in ("viser", "tomlkit"):
        raise error
    note("the lab needs viser: type `make lab`, or, in Tumble's checkout, `pip install '.[lab]'`")
    return 2
