"""The one-impact map: the true state just before an impact, and just after it, for whoever starts there.

An error of an engine grows from impact to impact; started from the true state before impact k it answers for that
impact alone.
"""

from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.contact.approach import Flight
from tumble.scenarios.truth.contact.motion import motion_of
from tumble.scenarios.truth.contact.record import state_of
from tumble.scenarios.truth.contact.timeline import IMPACT


class OneImpact(NamedTuple):
    """States, (13,), `lead_s` before an impact, in free flight, and `follow_s` after it; begins_s, time_s, ends_s:

    when these and the impact are [s].
    """

    before: Array
    after: Array
    begins_s: float
    time_s: float
    ends_s: float


def one_impact(scene: Scene, row: int, number: int, lead_s: float, follow_s: float) -> OneImpact:
    """Return impact `number`, from 1 on, of a throw, with the flight before it and the motion after it.

    lead_s, follow_s: from the impact [s]; the flight is taken back, and the motion on, no further than it lasts.
    Raises ValueError where there is no such impact, RayMissed.
    """
    from mpmath import MPContext  # only who asks pays for it

    mp: Any = MPContext()
    motion = motion_of(mp, scene, row)
    mp.prec = motion.bits
    setting, timeline = motion.setting, motion.finer
    impacts = [event for event in timeline.events if event.kind == IMPACT]
    if not 1 <= number <= len(impacts):
        raise ValueError(f"there is no impact {number}: the motion has {len(impacts)}")
    event = impacts[number - 1]
    others = [other.time for other in timeline.events if other is not event]
    first = max((time for time in others if time <= event.time), default=mp.zero)
    last = min((time for time in others if time >= event.time), default=min(setting.times[-1], timeline.ended))
    begins, ends = max(first, event.time - mp.mpf(lead_s)), min(last, event.time + mp.mpf(follow_s))
    before = Flight(setting, event.before, event.time).at(begins)
    after = timeline.at(ends) if ends > event.time else event.after
    before_state, after_state = state_of(motion, before), state_of(motion, after)
    after_state[3:7] *= np.sign(before_state[3:7] @ after_state[3:7]) or 1.0
    return OneImpact(before_state, after_state, float(begins), float(event.time), float(ends))
