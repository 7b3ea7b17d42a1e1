"""Newton's tests are there where it is installed; in CI it is not, for its kernels compile for minutes."""

from tumble.compare.run.engines.environments import environments

collect_ignore = [] if any(one.engine == "newton" for one in environments()) else ["test_newton.py"]
