"""Numbers for people: three significant digits, powers of ten as 2.31·10⁻¹¹, real minus signs."""

import math

MINUS = "\N{MINUS SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"
TIMES_TEN = "\N{MIDDLE DOT}10"
SUPERSCRIPTS = dict(zip("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", strict=True))


def figure(value: float, digits: int = 3) -> str:
    """Return a number in `digits` significant digits; plain from 0.001 to 10,000, else with a power of ten."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if value == 0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -3 <= power < 4:
        text = f"{float(f'{mantissa}e{power}'):.{max(digits - 1 - power, 0)}f}"
    else:
        text = mantissa + TIMES_TEN + superscript(power)
    return text.replace("-", MINUS)


def superscript(power: int) -> str:
    """Return an exponent in superscript digits."""
    return "".join(SUPERSCRIPTS[sign] for sign in str(power))


def fixed(value: float, decimals: int) -> str:
    """Return a number with this many decimals, without a minus sign before zero.

    Parameters
    ----------
    value : the number
    decimals : number of decimals

    Returns
    -------
    the text
    """
    return f"{value:z.{decimals}f}".replace("-", MINUS)


def given(value: float) -> str:
    """Return a number that a person chose, such as a time or a step, in full.

    Parameters
    ----------
    value : the number

    Returns
    -------
    the text, at most 12 significant digits
    """
    return f"{value:.12g}".replace("-", MINUS)


def listed(names: list[str]) -> str:
    """Return names as a list in a sentence: a, b and c."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def counted(count: int, noun: str) -> str:
    """Return a count with its noun: 1 scene, 2 scenes.

    Parameters
    ----------
    count : the count
    noun : the noun in the singular; its plural ends in s

    Returns
    -------
    the text
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
