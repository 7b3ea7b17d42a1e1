"""Judges a trajectory that some other program wrote, and says what is most likely wrong with that program.

`columns` and `foreign` read it, `digits` knows what its printed figures can tell; `reference` is the right motion at
any instant, `residual` what is off from it, `conserved` what is not kept; `account` says how a program may have flown,
`stepping` flies it so; `mistakes` has one entry per mistake, `hypotheses` says what an entry is; `diagnosis` searches
them and ranks what it finds by `noise`; `verdict` does it all for one file, and `rows` makes tables of it.
"""
