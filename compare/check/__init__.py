"""Regression checks: a record of accepted results, compared with what is measured now.

`study` is the way in; `record` has the record and its format; `measure` and `times` make one; `tolerances` say how
much may differ; `changes` compares two records; `words`, `markdown` and `junit` report what was found.
"""
