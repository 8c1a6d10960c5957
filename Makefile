# Everything a newcomer needs: `make demo` runs the whole chain, `make test` the tests. Both set up what they need.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.PHONY: help setup check test test-all test-wheel bench demo clean lock

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ONLY ?=
# a process a core, each with one thread: two threads on a busy core wait for each other; tests keep their bytecode too
PYTEST = $(COMPILE) && PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist worksteal
# bytecode, as an installed package has it: starting takes half as long, also where Python is told to write none
COMPILE = $(BIN)/python -m compileall -q base cli configs datasets export methods pipeline sim train
# uv where it works already, else a private one
UV = $(shell uv --version >/dev/null 2>&1 && echo uv || echo .uv/bin/uv)

help: ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

setup: $(VENV)/.installed ## install the locked environment and navtool into .venv

.uv/bin/uv:
	$(PYTHON) -m venv .uv
	.uv/bin/python -m pip install --quiet --disable-pip-version-check uv

$(VENV)/.installed: requirements.lock pyproject.toml
	@uv --version >/dev/null 2>&1 || $(MAKE) --no-print-directory .uv/bin/uv
	[ -x $(BIN)/python ] || $(UV) venv --quiet --python ">=3.12" $(VENV)
	$(UV) pip sync --quiet --compile-bytecode --python $(BIN)/python requirements.lock
	$(UV) pip install --quiet --python $(BIN)/python --no-deps --editable .
	$(COMPILE)
	touch $@

check: setup ## format, lint, types and import contracts
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	rm -rf .check build && $(UV) pip install --quiet --python $(BIN)/python --no-deps --target .check .
	MYPYPATH=.check $(BIN)/mypy -p navtool
	MYPYPATH=.check:benchmarks:tests/factories $(BIN)/mypy --explicit-package-bases tests benchmarks
	PYTHONPATH=.check $(BIN)/lint-imports

test: setup ## the quick tests
	$(PYTEST) -m "not slow" --durations=20

test-all: setup ## every test, the properties on new examples each time
	export NAVTOOL_EXPLORE=1; $(PYTEST)

test-wheel: setup ## the wheel in new environments, with the newest and the lowest versions that it allows
	$(BIN)/python tests/wheel/chain.py $(UV)

bench: setup ## benchmarks; ONLY=name runs one
	$(COMPILE)
	$(BIN)/python -m benchmarks $(ONLY)

demo: setup ## from generated recordings to a verified artefact
	$(BIN)/navtool demo --out demo-output

lock: ## renew requirements.lock from pyproject.toml
	$(UV) pip compile --quiet --universal --generate-hashes --all-extras --no-emit-index-url --no-annotate --no-header \
		--upgrade pyproject.toml --output-file requirements.lock

clean: ## remove everything that was made
	rm -rf $(VENV) .uv .check build dist *.egg-info demo-output runs multirun benchmarks/out
	rm -rf .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
