#!/usr/bin/env bash
# Runs the tests of the kernels (native/) compiled with what watches over memory and over what C leaves undefined.
set -euo pipefail
cd "$(dirname "$0")/.."
watched="$(mktemp -d)"
trap 'rm -rf "$watched"' EXIT
.venv/bin/python - "$watched" <<'PYTHON'
import sys
from pathlib import Path

from hatch_build import compiled

options = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")
sys.exit(compiled(Path(sys.argv[1], "_native.abi3.so"), *options))
PYTHON
export LD_PRELOAD="$(gcc -print-file-name=libasan.so) $(gcc -print-file-name=libubsan.so)"
export ASAN_OPTIONS=detect_leaks=0 PYTHONMALLOC=malloc TIMONEL_KERNELS="$watched/_native.abi3.so"
.venv/bin/python -m pytest -q -p tests.watched -n 0 -k "not interpreted" --timeout 900 \
    tests/unit/test_native.py tests/unit/recording tests/property/test_catalogue.py
