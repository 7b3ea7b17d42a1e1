"""`tumble advise`: the cheapest way to an error."""

from argparse import Namespace

from tumble.compare.run.running_engines import flights
from tumble.compare.sweep.work_precision import Effort, sweep
from tumble.finished import exit_code
from tumble.notes import note, progress
from tumble.reports.sweep_text import advice_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes
from tumble.taking_part import taking_part

# A ladder that ends where its tolerance is reached is short.
EFFORT = Effort(budget_s=0.15)
# What a ladder takes, in budgets of one flight: its last rungs take 1, 2/3, 1/2, 1/3 ... of one; and what timing takes.
LADDER, CLOCK_S = 5.0, 5.0


def main(options: Namespace) -> int:
    """Sweep each scene as far as the tolerance asks, and print what to use and what came how close."""
    scenes = read_scenes(options.scene)
    with taking_part(options.engine, options) as running_engines:
        count = flights(running_engines, scenes)
        seconds = count * LADDER * EFFORT.budget_s + len(scenes) * CLOCK_S
        note(f"{count} ladders of steps: about {seconds:.0f} s, or less where the tolerance is soon reached")
        with progress(count + len(scenes)) as on_progress:
            found = [
                sweep(
                    running_engines,
                    scene,
                    on_progress,
                    EFFORT,
                    enough_m=options.tolerance,
                    beyond_samples=options.beyond_samples,
                )
                for scene in scenes
            ]
        named = {f"{one.title}:{method}" for one in running_engines for method in one.named}
        out = console()
        for one in found:
            for piece in advice_text(one, options.tolerance, named):
                out.print(piece)
    return exit_code(run.status for one in found for run in one.runs)
