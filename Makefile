# Everything below sets up what it needs: a virtual environment with pinned dependencies.
PYTHON ?= python3
VENV := .venv
CONSTRAINTS := constraints.txt
BIN := $(VENV)/bin
# What came of the tests, where this project's gate looks for it.
FOUND := out/tests
STAMP := $(VENV)/.ready
# As an installation has it: where Python may not keep what it compiles, every start would compile all modules again.
# Tests too: each worker would compile all of them.
COMPILE := $(BIN)/python -m compileall -q -j 0 engine trace tests
# A file's tests stay together: they share what they prepare.
PARALLEL := -n auto --dist loadfile

LOOP := build/closed-loop

.PHONY: assess test oldest acceptance closed-loop embedded field bench lint format clean

assess: $(STAMP)  ## check, test, replay, collect evidence; writes out/assess/index.html
	$(BIN)/trackmarshal assess --out out/assess

test: $(STAMP)  ## everything that CI runs: what lints and what tests, at the same time, then this project's own gate; what came of tests is in out/tests
	$(MAKE) -j2 lint tests
	$(MAKE) gate

# What the tests found is in the matrix. The day is that of the commit, so that an old commit's waivers hold as they did then.
.PHONY: gate
gate: $(STAMP)
	$(BIN)/trackmarshal trace --gate --rerun --day commit

# What tests build with make is not of this one. Asserts as they stand: rewriting those of all tests takes each process longer than to
# find them; those that fail run again, and say what was compared.
.PHONY: tests
tests: $(STAMP)
	mkdir -p $(FOUND)
	rm -f $(FOUND)/pytest.json $(FOUND)/pytest.xml
	MAKEFLAGS= $(BIN)/python -m pytest $(PARALLEL) --assert=plain --junitxml=$(FOUND)/pytest.xml --trackmarshal-results=$(FOUND)/pytest.json \
		|| { MAKEFLAGS= $(BIN)/python -m pytest --last-failed --last-failed-no-failures none; false; }

oldest:  ## the tests with the least versions that pyproject.toml names, in an environment of its own
	$(MAKE) tests VENV=build/oldest CONSTRAINTS=tests/oldest.txt FOUND=build/oldest/found

acceptance: $(STAMP) $(LOOP)/.ready lint  ## every "Done when" point that can be a command; takes longer than CI
	sh tests/embedded/tools.sh
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt pyarrow  # reads our records independently
	TRACKMARSHAL_FUZZ_CYCLES=60000 TRACKMARSHAL_KILLS=200 TRACKMARSHAL_GENERATED=10000 TRACKMARSHAL_FUZZ=300000 TRACKMARSHAL_CYCLES=100000 TRACKMARSHAL_COMPILED=1000 \
	TRACKMARSHAL_RUNS=10000 TRACKMARSHAL_SEEDS=40 TRACKMARSHAL_WRAPS=4 TRACKMARSHAL_EXAMPLES=60 TRACKMARSHAL_OPTIMIZED=1 \
		$(BIN)/python -m pytest $(PARALLEL) --no-loadscope-reorder --durations=60 -m ""
	-TRACKMARSHAL_STEPS=1000000 $(BIN)/trackmarshal bench supervisor  # shown, not asserted: how busy the machine is counts too; `make bench` has all

# The planner runs in an environment of its own: it needs packages of another time.
$(LOOP)/.ready: tests/closed_loop/planner/requirements.txt
	$(PYTHON) -m venv $(LOOP)/venv
	$(LOOP)/venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps -r $<
	touch $@

closed-loop: $(STAMP) $(LOOP)/.ready  ## every fault in the closed loop, a quarter of an hour, resumable; JOBS=2 for two at once; see docs/closed-loop.md
	PYTHONPATH=tests $(BIN)/python -m closed_loop.campaign --jobs $(or $(JOBS),1) --keep
	PYTHONPATH=tests $(BIN)/python -m closed_loop.report

embedded: $(STAMP)  ## the emitted Supervisor on an emulated Cortex-M7 decides as here, bit for bit; figures in out/embedded
	sh tests/embedded/tools.sh
	$(BIN)/python -m pytest -m acceptance tests/acceptance/test_embedded.py

field: $(STAMP)  ## the shared log of a real drive again, where it is there: docs/field.md
	$(BIN)/trackmarshal import log --map specs/field/lvms.yaml --limits --keep specs/field/lvms.run.json

bench: $(STAMP)  ## CPU times, medians, as ratios where a yardstick is at hand
	$(COMPILE)
	$(BIN)/trackmarshal bench

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/trackmarshal fmt --check specs engine/trackmarshal/prelude
	rm -rf build/map && mkdir -p build/map && cp -r engine/trackmarshal trace/trackmarshal build/map  # one tree of both roots
	cd build/map && PYTHONPATH=$(CURDIR)/build/map $(CURDIR)/$(BIN)/lint-imports --config $(CURDIR)/pyproject.toml --no-cache

format: $(STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/trackmarshal fmt specs engine/trackmarshal/prelude

clean:
	rm -rf $(VENV) out build dist .mypy_cache .ruff_cache .pytest_cache
	find engine trace -name __pycache__ -exec rm -rf {} +

$(STAMP): pyproject.toml $(CONSTRAINTS)
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed; set PYTHON=")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c $(CONSTRAINTS) -e '.[dev]'
	$(COMPILE)
	-$(BIN)/python -m compileall -qq -j 0 -x '/(tests?|pip|mypyc?|setuptools)/' $(VENV)/lib  # on all cores, which pip does on one; what runs, or may
	touch $@
