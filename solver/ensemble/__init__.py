"""Many throws at once: lanes of a vector processor, blocks that stay in its nearest cache, and all its cores.

`lanes` says how a function becomes a lane, `blocks` how throws are dealt out to lanes and cores; then one file per
method, with the signature of `tumble.solver.integrators`.

A throw knows nothing of its neighbours: alone or among a million, in any lane, on any core, it gets the same bits.
They are those of the method's scalar kernel but for rounding: lanes contract to fused multiply-adds.
"""
