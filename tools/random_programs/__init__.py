"""Random rigid-body programs with known mistakes, and how well `tumble grade` reads their files.

    .venv/bin/python -m tools.random_programs --count 40 --seed date

It shares no code with the project: `contact.py` is the one place that runs a command of Tumble, `names.py` the one
that knows the names in its answers.
"""
