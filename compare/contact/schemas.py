"""The tables of contact: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import EMPTY, Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Method, SceneName, Tolerance

VERDICT_WORDS = {
    "Coulomb and Newton": "the law error is zero within its interval, or less than one step makes",
    "tunnels": "the body passes through the plane",
    "gains energy in an impact": "an impact adds energy where the law takes some",
    "gains energy as it rolls": "a disc on its rim gains energy, which friction that holds cannot give",
    "contact without touching": "the plane pushes before the body touches it",
    "another law: pyramid": "friction depends on the direction as that of a pyramid along the named axes does",
    "another law: friction": "a body that slides is braked as by another coefficient of friction, which is named",
    "creeps at": "a body that must rest moves at the named speed, at every step",
    "no restitution": "the body does not leave the plane",
    "restitution that depends on the step": "no rebound is approached as the step falls",
    "another law: restitution": "the rebound is that of another coefficient of restitution, which is named",
    "another law: Coulomb on the whole impulse": "an impact is that of Coulomb's friction of the impulse as a whole, "
    "as of time-stepping methods, and not at each instant of it",
    "depends on the step": "no value is approached as the step falls",
    "does not come to rest": "a body that must stop, rest or roll slips or bounces on to the end of the run",
    "soft": "the impact was not over when the next one was due",
    "another law": "the law error is not zero, and nothing else in this list names it",
    "not its own law": "a soft engine does not approach the law of contact that it states",
    "its own law": "the limit is that of the law of contact that a soft engine states, so far from Newton's",
    "sinks by": "the plane yields: the named depth remains as the step falls",
}


@dataclass(frozen=True, kw_only=True)
class ContactRow:
    """One observable of one contestant above a rigid plane: its error, and how much of it is the law's.

    The law error is the limit of the error as the step goes to zero; the step error is the rest.
    """

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step; empty where the method chose its own under a tolerance", EMPTY]
    tolerance: Tolerance
    observable: Annotated[str, "what is observed, as in docs/contact.md"]
    blow: Annotated[
        int | None,
        "number of the impact, from 1 on, from whose true state before it the run starts; empty of the whole run",
    ]
    value: Annotated[float | None, "value in the run; empty if it does not show one"]
    true: Annotated[float, "true value"]
    unit: Annotated[str, "unit of value, true, error, law_error and step_error"]
    error: Annotated[float | None, "value less the true one"]
    law_error: Annotated[float | None, "limit of the error as the step goes to zero; empty if unknown"]
    law_error_low: Annotated[float | None, "lower end of the interval of law_error"]
    law_error_high: Annotated[float | None, "upper end of the interval of law_error"]
    step_error: Annotated[float | None, "error less law_error"]
    order: Annotated[float | None, "order with which the step error falls; empty if it shows none"]
    verdict: Annotated[str, "; ".join(f"{name}: {meaning}" for name, meaning in VERDICT_WORDS.items())]


@dataclass(frozen=True, kw_only=True)
class ContactScanRow:
    """One run of a scan: a scene of which one number is changed, and what one contestant makes of it."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step"]
    scan: Annotated[
        str,
        "what is changed: direction, that of the first velocity from the plane's first axis; tilt, the tangent of the "
        "plane's tilt over friction; drop height, of a ball",
    ]
    at: Annotated[float, "the changed number, in at_unit"]
    at_unit: Annotated[str, "unit of at"]
    observable: Annotated[str, "what is observed"]
    value: Annotated[float | None, "value in the run; empty if it does not show one"]
    true: Annotated[float, "true value"]
    unit: Annotated[str, "unit of value and true"]


CONTACT = Table("contact.csv", ContactRow, (*CONTESTANT, "dt_s", "observable", "blow"))
SCANS = Table("contact-scans.csv", ContactScanRow, (*CONTESTANT, "dt_s", "scan", "at", "observable"))
TABLES = (CONTACT, SCANS)
