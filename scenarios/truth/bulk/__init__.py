"""The true flight of many free throws of one body, in one compiled loop: the closed form in numbers of 32 digits.

`number` is the arithmetic, of several throws side by side, `elliptic` and `rotation` the closed form, `kernel` the
loop, `bodies` what is worked out once for all throws, in fractions.  What it gives is held against the many-digit
closed form on throws that are drawn for it; a throw that is too delicate for 32 digits, or whose floor is no
derivative, is left to that one.
"""
