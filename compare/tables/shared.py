"""The tables that several studies write, each stated once: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.run.condition import ConditionRow
from tumble.compare.run.status import described
from tumble.compare.tables.schema import EMPTY, Table

RESOLUTION = "resolution of the reference: smaller errors are indistinguishable from zero"

SceneName = Annotated[str, "name of the scene"]
Engine = Annotated[str, "name of the engine"]
Method = Annotated[str, "METHOD[@TOLERANCE] of the engine; empty where the engine is missing"]
Step = Annotated[float, "step; empty where the method chose its own under a tolerance", EMPTY]
Tolerance = Annotated[float | None, "tolerance of an adaptive method; empty where there is a step"]
StepTaken = Annotated[
    float | None,
    "mean step of the whole run: below dt_s where samples and impulses cut it; empty where a tolerance chose the "
    "steps, or the run did not reach its end",
]
Instant = Annotated[float, "time of the sample"]
Vertex = Annotated[int, "number of the vertex"]
Status = Annotated[str, "ok, flagged, diverged, skipped, missing, crashed or timeout"]
Why = Annotated[str, "the reason of a status that is not ok"]
Steps = Annotated[
    int | None, "number of steps of the whole run; empty if there is no run, or the method chose its steps"
]
MaxError = Annotated[float | None, "largest error of any vertex, sample and throw; inf of one that diverged"]
RmsError = Annotated[float | None, "root mean square over all vertices, samples and throws"]
FinalError = Annotated[float | None, "largest error of any vertex and throw at the last sample"]
EnergyDrift = Annotated[float | None, "largest difference from the true energy, over the largest kinetic"]
MomentumDrift = Annotated[float | None, "largest difference from the true momentum, over the largest"]
AngularMomentumDrift = Annotated[float | None, "largest difference from the true angular momentum, over the largest"]
Limit = Annotated[float | None, RESOLUTION]


@dataclass(frozen=True, kw_only=True)
class VertexErrorRow:
    """One vertex of one run at one sample; of many throws the first, which is the scene as written."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    t_s: Instant
    vertex: Vertex
    true_x_m: Annotated[float, "true x of the vertex, world axes"]
    true_y_m: Annotated[float, "true y of the vertex, world axes"]
    true_z_m: Annotated[float, "true z of the vertex, world axes"]
    x_m: Annotated[float, "x of the vertex in the run, world axes; empty once it diverged", EMPTY]
    y_m: Annotated[float, "y of the vertex in the run, world axes; empty once it diverged", EMPTY]
    z_m: Annotated[float, "z of the vertex in the run, world axes; empty once it diverged", EMPTY]
    error_x_m: Annotated[float, "x in the run less the true x; empty once it diverged", EMPTY]
    error_y_m: Annotated[float, "y in the run less the true y; empty once it diverged", EMPTY]
    error_z_m: Annotated[float, "z in the run less the true z; empty once it diverged", EMPTY]
    error_m: Annotated[float, "distance of the vertex from the true one; empty once the run diverged", EMPTY]


@dataclass(frozen=True, kw_only=True)
class ErrorOverTimeRow:
    """The largest vertex error of one run at one sample, over all throws, and the truth's limit there."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    t_s: Instant
    error_m: Annotated[float, "largest error of any vertex and throw; empty once the run diverged", EMPTY]
    resolution_m: Annotated[float, RESOLUTION]


@dataclass(frozen=True, kw_only=True)
class MemberRow:
    """One throw of a scene of many, in one run: its largest vertex error, and the truth's limit."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    member: Annotated[int, "number of the throw; 0 is the scene's own"]
    max_error_m: Annotated[float, "largest error of any vertex and sample; empty of one that diverged", EMPTY]
    resolution_m: Annotated[
        float, "resolution of the reference for this throw: smaller errors are indistinguishable from zero"
    ]


@dataclass(frozen=True, kw_only=True)
class RunRow:
    """One run: errors over all vertices and samples, drifts from the truth, and what its native loop took.

    Where there is no flight or no truth the figures are empty and the status says why.
    """

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    steps: Steps = None
    status: Status
    why: Why = ""
    max_error_m: MaxError = None
    rms_error_m: RmsError = None
    final_error_m: FinalError = None
    resolution_m: Limit = None
    energy_drift: EnergyDrift = None
    momentum_drift: MomentumDrift = None
    angular_momentum_drift: AngularMomentumDrift = None
    wall_s: Annotated[float | None, "wall time of the native loop over the whole flight, one pass"] = None
    wall_ns_per_step: Annotated[float | None, "wall time of the native loop for one step of all throws, one pass"] = (
        None
    )
    wall_per_sim_s: Annotated[float | None, "wall time of the native loop for one second of flight, one pass"] = None
    dt_taken_s: StepTaken = None


@dataclass(frozen=True, kw_only=True)
class SceneRow:
    """One scene: what it needs, and how exact its truth is."""

    scene: SceneName
    title: Annotated[str, "its title"]
    source: Annotated[str, "where the case comes from"]
    needs: Annotated[str, "what an engine must have for it"]
    shape: Annotated[str, "box, mesh or rigid"]
    vertices: Annotated[int, "number of vertices"]
    duration_s: Annotated[float, "how long the flight is"]
    step_s: Annotated[float, "the scene's own step"]
    samples: Annotated[int, "number of instants at which errors are measured"]
    truth: Annotated[str, "how the truth is made, or why there is none"]
    bound_m: Annotated[float | None, "error bound of the reference solution, largest over the samples"]
    input_error_m: Annotated[
        float | None,
        "largest distance, over vertices and samples, that rounding the scene's numbers to doubles moves a vertex",
    ]
    horizon_s: Annotated[
        float | None,
        "predictability horizon: after it no double-precision program can follow the motion, and samples do not count; "
        "empty if there is none before the end",
    ] = None
    rounding_inputs_m: Annotated[
        float | None,
        "largest distance, over vertices and samples, that rounding moments, axes and points to doubles moves a vertex",
    ] = None


@dataclass(frozen=True, kw_only=True)
class EngineRow:
    """One engine: version, precision, methods, force laws, what was switched off to be fair; or why it is missing."""

    engine: Engine
    status: Annotated[str, "ok, missing or crashed"]
    why: Why = ""
    version: Annotated[str, "version of the engine; empty if it is missing"] = ""
    precision: Annotated[str, "single or double; empty if the engine is missing"] = ""
    methods: Annotated[str, "methods of the engine, its first choice first; of a missing one those asked for"]
    features: Annotated[str, "force laws that the engine has"] = ""
    switched_off: Annotated[str, "settings of the engine that were switched off to be fair"] = ""

    @property
    def outcome(self) -> str:
        """Status and reason as text for a person."""
        return described(self.status, self.why)


FINDING_WORDS = {
    "most accurate": "contestant with the smallest largest vertex error, and that error",
    "most accurate engine": "the same, excluding Tumble's own solver and the hand calculation",
    "first method": "largest vertex error of an engine's first method, the most accurate engine first",
    "engine default": "largest vertex error of an engine with its own defaults, if that took part",
    "named method": "largest vertex error of a contestant that the user named and that is no default of its engine",
    "least accurate": "contestant with the largest vertex error of those that finished, and that error",
    "unfinished": "number of contestants that started and did not finish",
    "unsupported": "number of contestants that do not support the scene or are not installed",
    "agreement distance": "largest distance between two engines that agree far better than either is right",
    "agreement error": "the larger of the two errors of those engines",
    "right column": "the printed column of Table 4.1 nearer to the exact motion, and its largest distance from it",
    "wrong column": "the other column, and its largest distance from the exact motion",
    "coordinate rounding": "rounding error of the largest coordinate of the scene in single precision",
    "optimal step": "step of a contestant's smallest error, if smaller steps are worse",
    "largest stable step": "contestant with the largest stable step, and that step in radians of the stiffest mode",
    "smallest stable step": "contestant with the smallest stable step, and that step in radians of the stiffest mode",
    "limits with theory": "number of stability limits for which theory gives a finite one, over all scenes",
    "limits matching theory": "number of those limits that are within 5 % of theory",
    "extreme cases": "number of extreme cases",
    "silent failures": "number of extreme cases in which a contestant ended with finite but unphysical numbers",
    "feature overhead": "contestant whose step gains most from switching off unneeded features, and the time ratio",
    "largest law error": "contestant with the largest law error of contact, and that error over the true value",
    "edge stretch": "length at the end over true length of a deformed body's most distorted edge",
}


@dataclass(frozen=True, kw_only=True)
class FindingRow:
    """One number of a sentence in the terminal or on the page: what was found, for which contestant, and how much."""

    finding: Annotated[str, "; ".join(f"{name}: {meaning}" for name, meaning in FINDING_WORDS.items())]
    scene: Annotated[str, "name of the scene; empty if the finding is about all scenes"] = ""
    engine: Annotated[str, "engine that the finding is about; empty if none"] = ""
    method: Annotated[str, "METHOD[@TOLERANCE] that the finding is about; empty if none"] = ""
    other: Annotated[
        str, "second contestant, ENGINE:METHOD, the column of a printed table, or the observable; empty if none"
    ] = ""
    value: Annotated[float | None, "the number; empty where there is a name and no number"]
    unit: Annotated[str, "its unit; 1 of a pure number"]
    resolution: Annotated[
        float | None, "resolution of the reference: smaller values are indistinguishable from zero"
    ] = None

    @property
    def contestant(self) -> str:
        """ENGINE:METHOD, ENGINE where the method is not known."""
        return f"{self.engine}:{self.method}" if self.method else self.engine


CONTESTANT = ("scene", "engine", "method")
RUNS = Table("runs.csv", RunRow, (*CONTESTANT, "dt_s"))
VERTEX_ERRORS = Table("vertex-errors.csv", VertexErrorRow, (*CONTESTANT, "dt_s", "t_s", "vertex"))
ERROR_OVER_TIME = Table("error-over-time.csv", ErrorOverTimeRow, (*CONTESTANT, "dt_s", "t_s"))
MEMBERS = Table("members.csv", MemberRow, (*CONTESTANT, "dt_s", "member"))
SCENES = Table("scenes.csv", SceneRow, ("scene",))
ENGINES = Table("engines.csv", EngineRow, ("engine",))
CONDITIONS = Table("conditions.csv", ConditionRow, ("what",))
FINDINGS = Table("findings.csv", FindingRow, ("finding", *CONTESTANT, "other"))
TABLES = (RUNS, VERTEX_ERRORS, ERROR_OVER_TIME, MEMBERS, SCENES, ENGINES, CONDITIONS, FINDINGS)
