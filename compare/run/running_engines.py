"""Engines that take part in a study, each in a process of its own, which is replaced when it crashes or hangs."""

import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import combinations

from tumble.compare.run.asked import chosen, engine_files, titles, wanted
from tumble.compare.run.contestant import MethodName
from tumble.compare.run.digest import NoValue
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.registry import BadEngine, EngineInfo
from tumble.compare.run.flight import Trajectory, takes_same_steps
from tumble.compare.run.local import Asked, LocalEngine, LocalWorker
from tumble.compare.run.pool import POOL
from tumble.compare.run.precision import DOUBLE, rounding
from tumble.compare.run.sensing import SensorReadings
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing.timer import Pace, Ready, Sample
from tumble.compare.run.worker import MEMORY_LIMIT, Worker
from tumble.scenarios.needs import FORCES, needs
from tumble.scenarios.scene import Scene

TIME_LIMIT_S = 60.0
# What a contestant is to its engine: what it does where nobody sets anything, or a method that the user named.
DEFAULT, AS_ASKED = "default", "as asked"


class Halted(Exception):
    """The command was interrupted, or another task failed: no more flights."""


@dataclass(eq=False)
class RunningEngine:
    """An engine that takes part.

    Parameters
    ----------
    engine : ENGINE[@RELEASE], or path of a user's file
    title : name of the engine in tables
    methods : methods that take part
    named : methods that were asked for by name, which run in every scene
    info : what the engine's file states, or why the engine is not available
    worker : the process that runs the engine, or the same in this process
    unasked : whether no engine was asked for; the engine then skips scenes whose sample instants it does not support
    """

    engine: str
    title: str
    methods: tuple[str, ...]
    named: frozenset[str]
    info: EngineInfo | Failure
    worker: Worker | LocalWorker
    unasked: bool = False
    _halted: bool = field(default=False, init=False)
    _ended: bool = field(default=False, init=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)

    def methods_for(self, scene: Scene) -> tuple[str, ...]:
        """Return the methods that take part: those named, and of the others those with a use in the scene."""
        if self.unasked and not self.answers_at(scene):
            return ()
        if isinstance(self.info, Failure):
            return self.methods
        unused = self.info.without_use(scene)
        return tuple(method for method in self.methods if method in self.named or method not in unused)

    @property
    def identity(self) -> list[object]:
        """What an answer depends on beside the question.  Raises NoValue of a function of the calling program."""
        if isinstance(self.worker, LocalWorker):
            raise NoValue(f"{self.title} is a function of the calling program")
        name = self.title if registry.is_file(self.engine) else self.engine
        return [name, self.worker.source, self.info, self.worker.time_limit, self.worker.memory_limit]

    @property
    def only_named(self) -> bool:
        """Whether every method was asked for by name, and the engine not also as a whole."""
        return self.named.issuperset(self.methods)

    def role(self, method: str) -> str:
        """Return what a method is to its engine: DEFAULT, AS_ASKED or ''."""
        if not isinstance(self.info, Failure) and method in self.info.default:
            return DEFAULT
        return AS_ASKED if method in self.named else ""

    def answers_at(self, scene: Scene) -> bool:
        """Whether the engine has an answer at the scene's sample instants; most have one at any."""
        known = () if isinstance(self.info, Failure) else self.info.instants
        return not known or scene.times.tolist() == list(known)

    def unsupported(self, scene: Scene) -> Failure | None:
        """Return why this engine cannot be put this question, or None."""
        if isinstance(self.info, Failure):
            return self.info
        lacking = [need for need in needs(scene) if need in FORCES and need not in self.info.features]
        return Failure(Status.SKIPPED, f"{self.title} has no {' or '.join(lacking)}") if lacking else None

    @property
    def rounding(self) -> float:
        """What one rounding moves a number of size 1, in the precision that the engine says it has."""
        return DOUBLE if isinstance(self.info, Failure) else rounding(self.info.precision)

    def takes_own_steps(self, method: str) -> bool:
        """Whether the method's steps are its own, so that a flight is the unit of its time."""
        if isinstance(self.info, Failure):
            return False
        return str(MethodName.parse(method).without_tolerance) in {*self.info.adaptive, *self.info.whole}

    def tolerance(self, method: str) -> float | None:
        """Return the tolerance under which the method chooses its steps, None of one that does not."""
        return None if isinstance(self.info, Failure) else self.info.tolerance(method)

    def simulate(
        self, scene: Scene, method: str, dt: float, keep: frozenset[str] = frozenset(), probe: bool = False
    ) -> Trajectory | Failure:
        """Return the flight, dt [s], or why there is none.

        keep: what of its OPTIONAL the engine is to build; probe: whether to run briefly from another start as well,
        which finds an engine that looks its answers up.  Raises Halted.
        """
        return self.unsupported(scene) or self.ensure_running() or self.worker.simulate(scene, method, dt, keep, probe)

    def simulate_watched(
        self, scene: Scene, method: str, dt: float, watched: Scene | None = None
    ) -> tuple[Trajectory | Failure, Trajectory | Failure | None]:
        """Return the flight, with a probe, and that of the watched scene, which has more samples; as `simulate`.

        One run answers both where it takes the same steps with all samples: of a method that chooses its own it does
        not, nor may it of a user's engine, whose steps need not add up.  watched: None, and so its flight: not asked.
        """
        if watched is None:
            return self.simulate(scene, method, dt, probe=True), None
        one_is_both = (
            len(scene.start) == len(watched.start)
            and not self.takes_own_steps(method)
            and not registry.is_file(self.engine)
            and not isinstance(self.worker, LocalWorker)
            and takes_same_steps(scene, watched, dt)
        )
        seen = self.simulate(watched, method, dt, probe=one_is_both)
        # A run that diverges ends at its first sample that is not finite, and the scene has fewer samples.
        if one_is_both and isinstance(seen, Trajectory) and seen.diverged_at is None:
            return seen.at(scene), seen
        return self.simulate(scene, method, dt, probe=True), seen

    def read_sensors(self, scene: Scene, method: str, dt: float) -> SensorReadings | Failure:
        """Return what the scene's sensors read in its first throw, or why they cannot be read.  Raises Halted."""
        if scene.plane is not None:
            return Failure(Status.SKIPPED, "sensors are not read above a rigid plane")
        return self.unsupported(scene) or self.ensure_running() or self.worker.read_sensors(scene, method, dt)

    def prepare_timer(
        self, key: str, scene: Scene, method: str, pace: Pace, keep: frozenset[str] = frozenset()
    ) -> Ready | Failure:
        """Make a timer ready under that key; return what that has shown, or why it cannot be."""
        return self.ensure_running() or self.worker.prepare_timer(key, scene, method, pace, keep)

    def sample(self, key: str) -> Sample | Failure:
        """Return one sample of that timer, or why there is none."""
        return self.worker.sample(key)

    def ensure_running(self) -> Failure | None:
        """Take a new worker where the last one crashed or hung; return why it does not come up, or None.

        Raises Halted.
        """
        if self.worker.alive:
            return None
        with self._lock:
            self.refuse_halted()
            self.worker = self.worker.renewed()
        info = self.worker.describe()
        return info if isinstance(info, Failure) else None

    def halt(self, for_good: bool = False) -> None:
        """Kill the process, from any thread; who waits for its answer gets a failure, and who asks again, Halted.

        for_good: whether no later study is to resume it.
        """
        with self._lock:
            self._halted, self._ended = True, self._ended or for_good
            self.worker.kill()

    def resume(self) -> None:
        """Take flights again after `halt`, but if that was for good."""
        if self._halted and not self._ended:
            self.worker.close()
            self._halted = False

    def refuse_halted(self) -> None:
        """Raise Halted where this participant was halted."""
        if self._halted:
            raise Halted


def flights(running_engines: Iterable[RunningEngine], scenes: Iterable[Scene]) -> int:
    """Return the number of runs: pairs of a method and a scene that it takes part in.

    Parameters
    ----------
    running_engines : the engines
    scenes : the scenes

    Returns
    -------
    the number of runs
    """
    running_engines = list(running_engines)
    return sum(len(running_engine.methods_for(scene)) for scene in scenes for running_engine in running_engines)


def truth_limit(running_engines: Sequence[RunningEngine]) -> float:
    """Return the wall time that each part of a truth may take [s]: as long as an answer of an engine."""
    return max((running_engine.worker.time_limit for running_engine in running_engines), default=TIME_LIMIT_S)


@contextmanager
def launched(
    asked: Iterable[Asked],
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    few: bool = False,
    beside: Iterable[str] = (),
) -> Iterator[list[RunningEngine]]:
    """Give the engines that take part, each with a process of its own, and end the processes afterwards.

    Parameters
    ----------
    asked : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each, or engines of this program; empty: the usual ones
    time_limit : for each answer of an engine [s]
    memory_limit : for each engine's process [B]
    few : of an engine without a method, only the methods that a page shows
    beside : contestants of another run, from which the titles of these must differ

    Returns
    -------
    a context that gives the running engines, in the order of `asked`, engines of this program last

    Raises
    ------
    BadEngine : an engine or a method is unknown, or two engines have one file or one name
    """
    asked = [*asked]
    local = {one.name: one for one in asked if isinstance(one, LocalEngine)}
    words = [one for one in asked if not isinstance(one, LocalEngine)]
    engines = wanted(words) if words or not local else {}
    named = titles((*engines, *engine_files(beside)))
    refuse_same_names(engines, named, [one for one in asked if isinstance(one, LocalEngine)])
    # All are started before any is waited for: importing the engines takes longest.
    pool = POOL.get()
    workers = [pool.worker(engine, time_limit, memory_limit) for engine in engines]
    workers += [LocalWorker(engine, time_limit) for engine in local.values()]
    running_engines: list[RunningEngine] = []
    try:
        methods_asked = [*engines.items(), *((name, [""]) for name in local)]
        for worker, (engine, methods) in zip(workers, methods_asked, strict=True):
            info = worker.describe()
            pool.started(engine, info, worker.source)
            taking_part, asked_by_name = chosen(engine, methods, info, few), frozenset(filter(None, methods))
            title = named.get(engine, engine)
            running_engines.append(
                RunningEngine(engine, title, taking_part, asked_by_name, info, worker, unasked=not asked)
            )
        yield running_engines
    except BaseException:
        for running_engine in running_engines:
            running_engine.worker.close()  # it may be killed, or at work still: no other study takes it over
        raise
    finally:
        for worker in {*workers, *(running_engine.worker for running_engine in running_engines)}:
            pool.release(worker)


def refuse_same_names(engines: Iterable[str], named: Mapping[str, str], local: Sequence[LocalEngine]) -> None:
    """Raise BadEngine where tables could not tell two engines apart.

    Parameters
    ----------
    engines : ENGINE[@RELEASE], or path of a user's file, of each
    named : their titles, and those of others
    local : engines of this program
    """
    for one, other in combinations(engines, 2):
        if named[one] == named[other]:
            raise BadEngine(f"{one} and {other} are one file: name it once")
    for engine in local:
        is_twice = any(other.name == engine.name for other in local if other is not engine)
        if is_twice or engine.name in named.values() or engine.name in registry.names():
            raise BadEngine(f"{engine.name}: two engines have this name; give the function another one")
