"""The tables of maps of stability and of the extreme cases: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Limit, Method, SceneName, Status, Step, Tolerance, Why

HOLDS, CREEPS, SLIDES, TIPS, TUNNELS, GAINS = "holds", "creeps", "slides", "tips", "tunnels", "gains energy"

Parameter = Annotated[str, "parameter that makes the scene stiff, with its unit"]
Word = Annotated[str, "verdict on the run, as `tumble stability` prints it"]
Ratio = Annotated[float | None, "energy at the end over its true value or physical bound; empty if there is no run"]
Worst = Annotated[float | None, "largest error over vertices and samples; inf if the run diverged"]


@dataclass(frozen=True, kw_only=True)
class StabilityRow:
    """One cell of a map: one contestant at one value of the scene's parameter and one step."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    parameter: Parameter
    value: Annotated[float, "value of the parameter"]
    status: Status
    why: Why
    verdict: Word
    max_error_m: Worst
    energy_ratio: Ratio
    resolution_m: Limit


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """The largest stable and accurate steps of one contestant in one scene, at the scene's own parameter value."""

    scene: SceneName
    engine: Engine
    method: Method
    parameter: Parameter
    value: Annotated[float, "value of the parameter in the scene"]
    w_rad_s: Annotated[float, "w: largest |eigenvalue| of the scene, linearised at the start"]
    w_dt_limit: Annotated[
        float | None,
        "largest w dt at which the energy stays bounded: 0 if it grows at every step, inf if at none that was tried; "
        "empty if the method chooses its own steps",
    ]
    beyond: Annotated[str, "verdict beyond w_dt_limit"]
    theory_w_dt: Annotated[
        float | None,
        "largest w dt at which the energy stays bounded by theory: 0 and inf as in w_dt_limit; empty if unknown",
    ]
    theory: Annotated[str, "source of theory_w_dt"]
    dt_stable_s: Annotated[float | None, "largest stable step; empty if none is"]
    dt_1pct_s: Annotated[
        float | None, "largest step with errors within 1 % of the largest true vertex displacement; empty if none is"
    ]
    dt_1mm_s: Annotated[float | None, "largest step with errors within 1 mm; empty if none is"]
    note: Annotated[str, "remark; empty if none"]


@dataclass(frozen=True, kw_only=True)
class ExtremeRow:
    """One contestant in one extreme case."""

    scene: SceneName
    title: Annotated[str, "title of the case"]
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    steps: Annotated[int | None, "steps of the whole run; empty if there is none"] = None
    status: Status
    verdict: Word
    max_error_m: Worst = None
    resolution_m: Limit = None
    error_over_resolution: Annotated[
        float | None, "largest ratio, over the samples, of error to resolution of the reference"
    ] = None
    energy_ratio: Ratio = None
    why: Annotated[str, "reasons of status and verdict"]
    size_m: Annotated[float, "largest distance of a vertex from the centre of mass"]


@dataclass(frozen=True, kw_only=True)
class ContactMapRow:
    """One cell of a map of friction and angle: a body set at rest on a face, on a plane tilted by that angle."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    friction: Annotated[float, "mu: friction of the pair"]
    angle_rad: Annotated[float, "angle of the plane with the horizontal"]
    critical_rad: Annotated[float, "critical angle: atan mu"]
    status: Status
    why: Why
    verdict: Annotated[
        str, f"{HOLDS}, {CREEPS} (at a steady speed), {SLIDES}, {TIPS} or {TUNNELS}; empty if the run has no end"
    ]
    true_verdict: Annotated[str, f"by Coulomb's law: {HOLDS}, {SLIDES} or {TIPS}"]
    speed_m_s: Annotated[float | None, "mean speed along the plane over the last quarter of the run"]
    true_speed_m_s: Annotated[float | None, "the true one; empty if the body tips"]


@dataclass(frozen=True, kw_only=True)
class ContactStepRow:
    """The largest step of one contestant in a scene with a plane, by laws that need no reference solution."""

    scene: SceneName
    engine: Engine
    method: Method
    status: Annotated[str, "ok, or the status of the run at the smallest step"]
    why: Why
    dt_max_s: Annotated[
        float | None,
        "largest step up to which the body neither passes the plane nor gains energy, at any step tried; inf if at "
        "none; empty if at the smallest, or if the method chooses its own steps",
    ] = None
    beyond: Annotated[str, f"{TUNNELS}, {GAINS} or diverged: verdict at the next larger step; empty if none"] = ""
    dt_from_s: Annotated[float | None, "smallest step tried"] = None
    dt_to_s: Annotated[float | None, "largest step tried"] = None
    max_speed_m_s: Annotated[float | None, "largest speed of the centre of mass at the smallest step"] = None


CELLS = Table("stability.csv", StabilityRow, (*CONTESTANT, "value", "dt_s"))
LIMITS = Table("limits.csv", LimitRow, CONTESTANT)
EXTREMES = Table("extremes.csv", ExtremeRow, CONTESTANT)
CONTACT_MAP = Table("contact-map.csv", ContactMapRow, (*CONTESTANT, "friction", "angle_rad"))
CONTACT_STEPS = Table("contact-steps.csv", ContactStepRow, CONTESTANT)
TABLES = (CELLS, LIMITS, EXTREMES, CONTACT_MAP, CONTACT_STEPS)
