"""The one-impact map: the true state just before an impact, and just after it, for whoever starts there.

An error of an engine grows from impact to impact; started from the true state before impact k it answers for that
impact alone.
"""

from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.contact.motion import motion_of
from tumble.scenarios.truth.contact.pinned import LANDS
from tumble.scenarios.truth.contact.record import state_of
from tumble.scenarios.truth.contact.timeline import IMPACT, Event


class OneImpact(NamedTuple):
    """States, (13,), `lead_s` before an impact and `follow_s` after it; begins_s, time_s, ends_s:

    when these and the impact are [s].
    """

    before: Array
    after: Array
    begins_s: float
    time_s: float
    ends_s: float


class ImpactMap:
    """The impacts of one throw of a scene, from whose neighbourhood a run may start.

    Parameters
    ----------
    scene
    row
        of the throw

    Raises
    ------
    RayMissed
    """

    def __init__(self, scene: Scene, row: int) -> None:
        from mpmath import MPContext  # only who asks pays for it

        self._mp: Any = MPContext()
        self._motion = motion_of(self._mp, scene, row)
        self._impacts = [event for event in self._motion.finer.events if event.kind == IMPACT]

    def __len__(self) -> int:
        return len(self._impacts)

    def gaps(self, number: int) -> tuple[float, float]:
        """Return how long the motion before an impact, from 1 on, has lasted, and the motion after it lasts [s]."""
        event, first, last = self._around(number)
        return float(event.time - first), float(last - event.time)

    def near(self, number: int, lead_s: float, follow_s: float) -> OneImpact:
        """Return an impact, from 1 on, with the motion before and after it.

        lead_s, follow_s: from the impact [s]; no further back, and on, than the motion lasts.
        Raises ValueError where there is no such impact.
        """
        event, first, last = self._around(number)
        motion, mp = self._motion, self._mp
        begins, ends = max(first, event.time - mp.mpf(lead_s)), min(last, event.time + mp.mpf(follow_s))
        before = motion.finer.at(begins) if begins < event.time else event.before
        after = motion.finer.at(ends) if ends > event.time else event.after
        before_state, after_state = state_of(motion, before), state_of(motion, after)
        after_state[3:7] *= np.sign(before_state[3:7] @ after_state[3:7]) or 1.0
        return OneImpact(before_state, after_state, float(begins), float(event.time), float(ends))

    def _around(self, number: int) -> tuple[Event, Any, Any]:
        """Return the event of an impact, and when the events before and after it are.  Raises ValueError."""
        if not 1 <= number <= len(self):
            raise ValueError(f"there is no impact {number}: the motion has {len(self)}")
        setting, timeline = self._motion.setting, self._motion.finer
        self._mp.prec = self._motion.bits
        event = self._impacts[number - 1]
        others = [other.time for other in timeline.events if other is not event and other.kind != LANDS]
        first = max((time for time in others if time <= event.time), default=self._mp.zero)
        last = min((time for time in others if time >= event.time), default=min(setting.times[-1], timeline.ended))
        return event, first, last
