"""Judges a trajectory that some other program wrote, and says what is most likely wrong with that program.

`columns` and `foreign` read it, `digits` knows what its printed figures can tell; `reference` is the exact motion at any
instant, `residual` what is off from it; `account` says how a program may have flown, `stepping` flies it so;
`hypotheses` has one entry per mistake, `diagnosis` searches them and ranks what it finds, `verdict` says what it means.
"""
