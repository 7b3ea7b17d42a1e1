"""Everything that results depend on, as rows of conditions.csv."""

from collections.abc import Sequence

from tumble.compare.run.condition import ConditionRow
from tumble.compare.run.digest import digest
from tumble.compare.run.provenance import conditions
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.tables.engines import engine_row
from tumble.scenarios.scene import Scene


def circumstances(
    running_engines: Sequence[RunningEngine], scenes: Sequence[Scene], asked: dict[str, str], command: str
) -> list[ConditionRow]:
    """Return format, machine, versions, what else was asked for, engines with their files, and the scenes."""
    found = [*conditions(command), *(ConditionRow(what, value) for what, value in asked.items())]
    for running_engine in running_engines:
        methods = ", ".join(
            running_engine.methods if running_engine.only_named else ("all methods", *sorted(running_engine.named))
        )
        source = running_engine.worker.source
        file = f", file {source}" if source else ""
        found.append(
            ConditionRow(f"engine {running_engine.title}", f"{engine_row(running_engine).version}, {methods}{file}")
        )
    return [*found, *(ConditionRow(f"scene {scene.name}", digest(scene)) for scene in scenes)]
