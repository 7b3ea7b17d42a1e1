"""The rows of a contestant's results."""

import math
from collections.abc import Iterator

from tumble.compare.contact.schemas import ContactRow, ContactScanRow
from tumble.compare.contact.study import Contact
from tumble.compare.contact.verdicts import verdicts


def contact_rows(contact: Contact) -> Iterator[ContactRow]:
    """Yield the observables of one contestant in one scene.

    Parameters
    ----------
    contact : the contestant's results

    Returns
    -------
    rows of contact.csv
    """
    for one, verdict in zip(contact.observations, verdicts(contact), strict=True):
        asked, limit = one.asked, one.limit
        yield ContactRow(
            scene=contact.scene.name,
            engine=contact.engine,
            method=contact.method,
            dt_s=one.dt_s if contact.tolerance is None else math.nan,
            tolerance=contact.tolerance,
            observable=asked.observable,
            blow=asked.impact,
            value=known(one.value),
            true=asked.true,
            unit=asked.unit,
            error=known(one.value - asked.true),
            law_error=known(limit.value - asked.true),
            law_error_low=known(limit.low - asked.true),
            law_error_high=known(limit.high - asked.true),
            step_error=known(one.value - limit.value),
            order=limit.order,
            verdict=verdict,
        )


def scan_rows(contact: Contact) -> Iterator[ContactScanRow]:
    """Yield a contestant's slides in all directions, and its other scans.

    Parameters
    ----------
    contact : the contestant's results

    Returns
    -------
    rows of contact-scans.csv
    """
    rose = contact.rose
    path, end = ("path", "stops") if contact.scene.body.radius is None else ("slip", "begins to roll")
    way = "distance" if path == "path" else "length of the slip"
    for slide in rose.slides if rose else ():
        for observable, value, true, unit in (
            (f"{way} until it {end}", slide.distance, rose.true if rose else math.nan, "m"),
            (f"turn of the {path} until it {end}", slide.turn, 0.0, "rad"),
        ):
            yield ContactScanRow(
                scene=contact.scene.name,
                engine=contact.engine,
                method=contact.method,
                dt_s=rose.dt_s if rose else math.nan,
                scan="direction",
                at=slide.direction,
                at_unit="rad",
                observable=observable,
                value=known(value),
                true=true,
                unit=unit,
            )
    for one, value in zip(contact.question.scans, contact.readings.scanned, strict=False):
        yield ContactScanRow(
            scene=contact.scene.name,
            engine=contact.engine,
            method=contact.method,
            dt_s=one.scene.step,
            scan=one.scan,
            at=one.at,
            at_unit=one.at_unit,
            observable=one.observable,
            value=known(value),
            true=one.true,
            unit=one.unit,
        )


def known(value: float) -> float | None:
    """Return a number, None for nan."""
    return None if math.isnan(value) else value
