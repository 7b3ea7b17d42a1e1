"""How much a column may change before it is worse or better: one number per column, set in a TOML file."""

import math
import tomllib
from dataclasses import dataclass, fields
from pathlib import Path

from tumble.scenarios.files import plain_bytes, why_unread
from tumble.scenarios.format import nearest, printable, short
from tumble.scenarios.refusal import UserError


class BadTolerance(UserError):
    """A tolerance file that cannot be used; the message is the one line for the user."""


@dataclass(frozen=True)
class Tolerances:
    """How much each column may change.

    Changes of errors and drifts count beyond what rounding explains.

    Parameters
    ----------
    max_error_m : relative change of the largest error
    rms_error_m : relative change of the root mean square error
    final_error_m : relative change of the error at the last sample
    energy_drift : relative change of the drift of the energy
    momentum_drift : relative change of the drift of the momentum
    angular_momentum_drift : relative change of the drift of the angular momentum
    attitude_order : absolute change of the order of the attitude
    translation_order : absolute change of the order of the translation
    law_error : relative change of an observable's law error above a plane, beyond both intervals
    contact_error : relative change of an observable's error above a plane, at the scene's step
    time_ratio : relative change of the run time's ratio; large, because processors differ
    """

    max_error_m: float = 0.05
    rms_error_m: float = 0.05
    final_error_m: float = 0.05
    energy_drift: float = 0.05
    momentum_drift: float = 0.05
    angular_momentum_drift: float = 0.05
    attitude_order: float = 0.25
    translation_order: float = 0.25
    law_error: float = 0.05
    contact_error: float = 0.05
    time_ratio: float = 0.5


def read_tolerances(file: str | None) -> Tolerances:
    """Return the tolerances of a TOML file.

    Parameters
    ----------
    file : its path; None: the defaults

    Returns
    -------
    the tolerances, with defaults for those that the file does not set

    Raises
    ------
    BadTolerance : the file cannot be read, or has a bad key or value
    """
    if file is None:
        return Tolerances()
    shown = printable(file)
    try:
        document = tomllib.loads(plain_bytes(Path(file)).decode("utf-8-sig"))
    except OSError as error:
        raise BadTolerance(f"{shown}: {why_unread(error)}") from None
    except RecursionError:
        raise BadTolerance(f"{shown}: not TOML: nested too deeply") from None
    except ValueError as error:  # TOMLDecodeError, UnicodeDecodeError, an integer of thousands of digits
        raise BadTolerance(f"{shown}: not TOML: {printable(str(error))}") from None
    known = [field.name for field in fields(Tolerances)]
    for key, value in document.items():
        if key not in known:
            raise BadTolerance(f"{shown}: {short(key)}: unknown key; {nearest(key, known)}")
        # An integer of thousands of digits overflows a float: it is compared, not converted.
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < math.inf:
            raise BadTolerance(f"{shown}: {key} = {short(value)}: must be a finite number >= 0")
    return Tolerances(**document)
