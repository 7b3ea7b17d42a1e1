"""Regression checks: what was measured once is kept as a record, and what is measured now is held against it.

`record` is what is kept and its format; `measure`, `order`, `energy` and `times` make one; `tolerances` say how much
may differ; `changes` holds two records against each other; `words`, `markdown` and `junit` say what was found.
"""
