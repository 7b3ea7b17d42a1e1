"""Judges a trajectory that some other program wrote, and says what is most likely wrong with that program.

`columns` has the names that columns may have, `mapping` what the user says of others, `header` what a file's columns
show, `offers` what a foreign one may be meant for; `cells` and `foreign` read it, `digits` knows what its printed
figures can tell.  `reference` is the right motion at any instant, `residual` what is off from it, `conserved` what is
not kept, `sightings` what is cheap to see, and `spin` what is wrong with the angular velocity that is written down.
`account` says how a program may have flown, `kernel` flies it so; `mistakes` has one entry per mistake, `engines` one
line per engine, `hypotheses` says what an entry is; `flights` holds them against the rows, `fitting` finds their
numbers, and `diagnosis` searches them and ranks what it finds by `noise`.  `verdict` does it all for one file, and
`rows` makes tables of it.
"""
