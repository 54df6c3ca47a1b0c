# The two commands a fresh machine needs are `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
VCAN ?= ../shared/tools/vcan_qemu.sh# runs a command where there is a vcan0
NPM_DONE := node_modules/.package-lock.json
PEERS := tests/interop/node/node_modules/.package-lock.json# a Signal K server to talk to
# What fails is tried once more, alone: programs, browsers and deadlines of milliseconds share the cores with each other.
PYTEST := $(BIN)/python -m pytest -m "not slow"
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: help demo test test-all lint mutation docs bench lock vendor clean
help:
	@echo "make demo      a simulated boat, the gateway, and what to connect to it"
	@echo "make test      every check that a change must pass"
	@echo "make test-all  those, and the slow ones (a real SocketCAN bus in a virtual machine, a million mutations)"
	@echo "make mutation  break the safety machines on purpose and see the tests notice"
	@echo "make bench     the tables of docs/performance.md"
	@echo "make docs      the reference pages that are made from the declarations"
	@echo "make lock      resolve the pinned versions anew"
	@echo "make vendor    what the console has from npm, bundled anew"

demo: $(VENV)/run
	$(BIN)/timonel demo

test: $(VENV)/dev lint $(PEERS)
	scripts/debian.sh gpsd gpsd-clients mosquitto mosquitto-clients chromium
	$(PYTEST) -n auto --dist loadfile || $(PYTEST) --last-failed --last-failed-no-failures none

test-all: test mutation
	scripts/debian.sh qemu-system-x86 busybox-static cpio kmod
	$(BIN)/python -m pytest -m slow --timeout 1800 --ignore tests/slow
	$(VCAN) -- $(BIN)/python -m pytest tests/slow --timeout 600
	scripts/sanitize.sh

lint: $(VENV)/dev $(NPM_DONE)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	node_modules/.bin/tsc

mutation: $(VENV)/dev
	$(BIN)/python -m tests.mutation

docs: $(VENV)/dev
	$(BIN)/python scripts/make_reference.py
	$(BIN)/python scripts/make_stop_table.py
	$(BIN)/python scripts/make_screenshot.py
	TIMONEL_PICTURES=1 $(BIN)/python -m pytest -q tests/browser -k pictured

bench: $(VENV)/dev
	$(BIN)/python -m benchmarks.live
	$(BIN)/python -m benchmarks.codec
	$(BIN)/python -m benchmarks.rover
	$(BIN)/python -m benchmarks.framing
	$(BIN)/python -m benchmarks.recorder
	$(BIN)/python -m benchmarks.decode
	$(BIN)/python -m benchmarks.decode_program
	$(BIN)/python -m benchmarks.convert

lock: $(VENV)/dev
	scripts/lock.sh

vendor: $(NPM_DONE)
	node scripts/vendor.mjs

clean:
	rm -rf node_modules tests/interop/node/node_modules $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis

# What is compiled of it, if it can be.
KERNELS := hatch_build.py $(wildcard native/*)

# One environment: `run` holds what the program needs, `dev` what the tests need too.
$(VENV)/bin/python:
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || scripts/debian.sh --required python3-venv
	$(PYTHON) -m venv $(VENV)

# For the checks and for `make vendor` alone: what is run and shipped needs no Node.
$(NPM_DONE): package-lock.json
	@command -v npm >/dev/null || scripts/debian.sh --required npm
	npm ci --ignore-scripts --no-audit --no-fund --silent

$(PEERS): tests/interop/node/package-lock.json
	@command -v npm >/dev/null || scripts/debian.sh --required npm
	npm ci --prefix tests/interop/node --ignore-scripts --omit=optional --no-audit --no-fund --silent

$(VENV)/run: requirements.lock pyproject.toml $(KERNELS) | $(VENV)/bin/python
	$(PIP) install --require-hashes --only-binary :all: -r requirements.lock
	$(PIP) install --no-deps --no-build-isolation --editable .
	touch $@

$(VENV)/dev: requirements-dev.lock pyproject.toml $(KERNELS) | $(VENV)/bin/python
	scripts/debian.sh gcc libc6-dev
	@$(BIN)/python -c 'import os, sysconfig as s; exit(not os.path.exists(s.get_path("include") + "/Python.h"))' || \
		scripts/debian.sh python3-dev
	$(PIP) install --require-hashes --only-binary :all: -r requirements-dev.lock
	$(PIP) install --no-deps --no-build-isolation --editable .
	touch $@ $(VENV)/run
