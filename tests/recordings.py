"""Where the public recordings are that tests and benchmarks read in place."""

import os
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("TIMONEL_RECORDINGS", Path(__file__).parents[2] / "shared" / "data"))
SHARED = ROOT.parent


def recording(name: str) -> Path:
    """The file `name` below the recordings' folder; a test without it fails where recordings were promised."""
    path = ROOT / name
    if not path.exists():
        pytest.fail(f"{path}: no such recording (TIMONEL_RECORDINGS names the folder)")
    return path


def vectors(name: str) -> Path:
    """An executable statement of the specification."""
    path = SHARED / "vectors" / name
    if not path.exists():
        pytest.fail(f"{path}: no such vector file (TIMONEL_RECORDINGS names the folder beside `vectors`)")
    return path
