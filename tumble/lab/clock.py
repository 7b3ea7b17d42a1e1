"""The time shown: it runs, stops, is set and slowed down; only computed instants are ever shown."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

WATCHED_S = 4.0  # a flight is shown in at least this time, at one of the speeds, the fastest that will do
SPEEDS = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)


def pace(duration: float) -> float:
    """Return the default speed at which a flight of this duration [s] is shown."""
    return next((speed for speed in SPEEDS if duration / speed >= WATCHED_S), SPEEDS[-1])


@dataclass(frozen=True)
class Clock:
    """instants [s] that can be shown, ascending from 0; speed: seconds of flight a second of watching.

    at: the flight's time [s] when the clock was last touched; since: the watch [s] then, None while it stands.
    """

    instants: Sequence[float]
    speed: float
    at: float = 0.0
    since: float | None = None

    @property
    def is_running(self) -> bool:
        """Whether time goes on."""
        return self.since is not None

    def time(self, watch: float) -> float:
        """Return the flight's time [s] at a time of the watch [s]; it stays at the end."""
        ran = 0.0 if self.since is None else (watch - self.since) * self.speed
        return min(self.at + ran, self.instants[-1])

    def frame(self, watch: float) -> int:
        """Return the number of the last instant that is not later than the time; nothing is interpolated."""
        return int(np.searchsorted(self.instants, self.time(watch), side="right")) - 1

    def started(self, watch: float) -> Self:
        """Return the clock running, from the start again if it was at the end."""
        at = self.time(watch)
        return replace(self, at=0.0 if at >= self.instants[-1] else at, since=watch)

    def stopped(self, watch: float) -> Self:
        """Return the clock standing at the instant shown."""
        return self.put(self.frame(watch))

    def put(self, frame: int) -> Self:
        """Return the clock standing at an instant."""
        return replace(self, at=self.instants[frame], since=None)

    def paced(self, watch: float, speed: float) -> Self:
        """Return the clock at another speed."""
        return replace(self, at=self.time(watch), since=None if self.since is None else watch, speed=speed)

    def limited_to(self, watch: float, most: float) -> Self:
        """Return the clock, which waits where it would pass that time [s]."""
        if self.since is None or self.time(watch) <= most:
            return self
        return replace(self, at=most, since=watch)
