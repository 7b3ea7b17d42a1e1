"""One file per method: n steps of the rotation of many throws, and, of some methods, of whole states under forces.

Every method has a kernel with the signature

    method(spins, n, dt, inverse_moments, gyroscopic)

spins: one row a throw, altered in place: the attitude as the method keeps it, then the angular momentum [kg m2/s];
n: steps; dt [s]; inverse_moments [1/(kg m2)] and gyroscopic, or None for a body of equal moments:
`tumble.solver.body.Body`.
A step knows nothing but the row, so that n steps and then m more are n + m steps to the last bit.  A dense method goes
to an instant instead: n counts from where its rows remember, `tumble.solver.spins.load_anchor`, and an adaptive one
takes its tolerance as a last argument.  The translation of a free flight is not stepped at all: `tumble.solver.flight`.

A method that carries forces has one more, with the signature

    method_forced(rows, n, dt, moments, inverse_moments, gyroscopic, forces)

rows: x, q, v, L and what else the method remembers; moments [kg m2]; inverse_moments, None for a body that never turns,
of which position and velocity alone are stepped; forces: `tumble.solver.forces.Forces`.  The equations are those of
`tumble.solver.motion`.
"""
