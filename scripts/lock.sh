#!/usr/bin/env bash
# Resolves the pinned versions: everything for the tests, and of these what the program itself needs.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -x .venv/bin/uv ] || .venv/bin/python -m pip --quiet install uv
compile() { .venv/bin/uv pip compile --quiet --universal --generate-hashes --no-header --python-version 3.11 "$@"; }
compile --extra all --group dev --output-file requirements-dev.lock pyproject.toml
compile --extra all --group build --constraint requirements-dev.lock --output-file requirements.lock pyproject.toml
