"""The truth above a rigid plane: Newton's restitution, Coulomb's friction, one impact at a time.

`setting` reads a throw; `timeline` puts its motion together from phases (`approach`: free flight and the next contact,
`sphere`, `face`) and from impacts (`impact`, on the equation of slip, `slip_flow`); `answer` says how good it is, and
`record` what of it is told: events, observables, and sets of outcomes.
"""
