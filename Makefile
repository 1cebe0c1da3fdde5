PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WORKERS ?= 2
PYTEST := $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -p no:benchmark --durations=10

DOCS_JOBS ?= 2

# Tests start a hundred processes and rewrite their own asserts: without bytecode that is kept, each does it all anew.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo wheel release test check test-deep slow races coverage bounds faults lowest newest tools docs bench tables bench-peers bench-compare bench-cold gate peers lint clean
.DELETE_ON_ERROR:

# An environment is made anew when pyproject.toml changes.
$(VENV)/.demo: pyproject.toml
	$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'fastaff needs Python 3.11 or newer; name one: make PYTHON=python3.12')"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[demo]"
	touch $@

$(VENV)/.first: $(VENV)/.demo  ## what edits, tests and linters need, without the site and benchmarks
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[test,lint]"
	touch $@

$(VENV)/.dev: $(VENV)/.demo
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[dev,demo]"
	touch $@

demo: $(VENV)/.demo  ## the main job: a Poincaré map and a frequency map
	$(BIN)/fastaff demo --out demo

wheel: $(VENV)/.demo  ## dist/*.whl with machine code for x86-64-v3 and v4, for this version of Python and Numba
	$(BIN)/python .ci/wheel.py dist

release: $(VENV)/.dev  ## all of a release but the upload: dist/ with sdist, wheel and the text of the tag, all checked
	$(BIN)/python .ci/release.py dist

test: $(VENV)/.dev  ## the tests of every change, on WORKERS cores
	$(PYTEST) -m "not slow and not race"

check: $(VENV)/.first  ## the fast tests that differ from BASE (HEAD), or name a module that does or stands on one
	$(BIN)/python .ci/check.py $(BASE)

test-deep: $(VENV)/.dev  ## the deep tier: the stages whose files have changed since they passed; writes .ci/deep.json
	$(BIN)/python .ci/deep.py --run

slow: $(VENV)/.dev  ## tests that take long, a stage of the deep tier
	$(PYTEST) -m "slow and not race"

races: $(VENV)/.dev  ## tests of signals, kills, threads, processes and clocks, one at a time: a stage of the deep tier
	$(BIN)/python -m pytest -p no:benchmark --durations=10 -m race

bounds: $(VENV)/.dev  ## every public call once, indices of all kernels checked
	NUMBA_BOUNDSCHECK=1 $(PYTEST) tests/package/test_inputs.py -k calls_that_work

coverage: $(VENV)/.dev  ## which lines of Python the tests of every change do not reach; compiled kernels have naive twins
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[coverage]"
	$(BIN)/python -m coverage erase
	$(BIN)/python -m coverage run -m pytest -n $(WORKERS) --dist worksteal -p no:benchmark -m "not slow and not race"
	$(BIN)/python -m coverage combine --quiet
	$(BIN)/python -m coverage report

FAULTS := tests/package/test_inputs.py tests/cli/test_kills.py tests/cli/test_cli_faults.py tests/jobs/test_jobs.py tests/engine/test_jit_cache.py \
	tests/engine/test_threads.py tests/core/test_placing.py tests/engine/test_code_keys.py tests/jobs/test_job_seals.py tests/results/test_recipe.py

faults: $(VENV)/.dev  ## 10^5 wrong inputs, 10^4 command lines, 1000 kills, damaged caches: an hour
	FASTAFF_FAULTS=10 $(PYTEST) $(FAULTS)

OTHERS := tests/cli/test_cli_jobs.py tests/jobs/test_job_store.py tests/plot/test_plot.py tests/systems/test_formula.py

# What is installed there may warn of its use of other packages.
ELSEWHERE = -m pytest -n $(WORKERS) --dist worksteal -p no:benchmark \
	-W ignore::DeprecationWarning -W ignore::PendingDeprecationWarning

lowest: $(VENV)/.lowest  ## some tests with the lowest versions that pyproject.toml allows
	$(VENV)/lowest/bin/python $(ELSEWHERE) -m "not slow and not race" $(OTHERS)

newest: NEWEST = $(shell $(PYTHON) .ci/newest.py)

newest: $(VENV)/.dev  ## the same with the newest Python of this machine
	@test -n "$(NEWEST)" || echo "there is no newer Python here"
	test -z "$(NEWEST)" || test -d $(VENV)/newest || $(NEWEST) -m venv $(VENV)/newest
	test -z "$(NEWEST)" || $(VENV)/newest/bin/python -m pip install --quiet --disable-pip-version-check -e ".[test]"
	test -z "$(NEWEST)" || $(VENV)/newest/bin/python $(ELSEWHERE) -m "not slow and not race" $(OTHERS)

$(VENV)/.lowest: pyproject.toml $(VENV)/.dev
	$(PYTHON) -m venv $(VENV)/lowest
	$(PYTHON) .ci/lowest.py > $(VENV)/lowest/versions.txt
	$(VENV)/lowest/bin/python -m pip install --quiet --disable-pip-version-check -c $(VENV)/lowest/versions.txt -e ".[test]"
	touch $@

tools: $(VENV)/.tools  ## all tests of adapters with the packages that they read, none of which may be missing
	FASTAFF_TOOLS=1 $(VENV)/tools/bin/python $(ELSEWHERE) tests/exchange

$(VENV)/.tools: pyproject.toml
	$(PYTHON) -m venv $(VENV)/tools
	$(VENV)/tools/bin/python -m pip install --quiet --disable-pip-version-check -e ".[test,tools]"
	touch $@

docs: $(VENV)/.dev  ## the site, all its code run: docs/_build/html/index.html; any warning is an error
	$(BIN)/python -m sphinx -b html -E -W --keep-going -q -j $(DOCS_JOBS) docs docs/_build/html

bench: $(VENV)/.dev  ## benchmarks with their errors
	$(BIN)/python -m pytest bench -s --benchmark-columns=min,median,rounds

tables: peers  ## measure the tables of the site anew, all of one commit: bench/results, bench/history, docs
	$(BIN)/python bench/tables.py

bench-peers: peers  ## the race beside other programs: bench/results, README's table (ROWS='Section': some rows, printed)
	PYTHONPATH=bench:tests $(BIN)/python -m race --rows "$(ROWS)"

bench-compare: $(VENV)/.dev  ## this tree beside the commit BASE, in turns
	$(BIN)/python bench/compare.py $(BASE)

bench-cold: $(VENV)/.dev  ## the first call of each kind in fresh processes
	$(BIN)/python bench/cold.py

gate: $(VENV)/.dev  ## ratios of processor times within one run; warns above bounds, writes bench/results/gate.json
	$(BIN)/python bench/gate.py --write bench/results/gate.json

peers: $(VENV)/.dev  ## the programs that benchmarks compare with
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[peers]"

lint: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

clean:
	rm -rf $(VENV) demo build docs/_build docs/_generated *.egg-info .pytest_cache .hypothesis .mypy_cache .ruff_cache .benchmarks
