"""Grades a trajectory that some other program wrote, and diagnoses what is most likely wrong with that program.

`grade` is the way in; `tables` and `results` are the ways out.  The rooms, from the bottom up:

`model`: how a program simulates a throw, right or wrong, compiled in `model.kernel`; and the reference motion.
`read`: reads a file of any program, or reports in one line what is ambiguous in it.
`measure`: errors, conserved quantities, observations that need no search, and the scale that residuals are compared to.
`hypotheses`: mistakes, and the schemes of engines, as data.
`search`: finds the hypotheses that explain a file; `search.stages` lists what is tried, in order.
"""
