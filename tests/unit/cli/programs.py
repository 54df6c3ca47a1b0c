"""The programs as a user starts them."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).parents[3] / "src"
STATE = tempfile.TemporaryDirectory(prefix="timonel-state-")  # what one run of the tests remembers, the next must not
ENVIRONMENT = os.environ | {"PYTHONPATH": str(SOURCE), "NO_COLOR": "1", "XDG_STATE_HOME": STATE.name}
TIMONEL = (sys.executable, "-c", "from timonel.cli.main import main; main(prog_name='timonel')")


def timonel(*arguments: str, stdin: bytes = b"") -> subprocess.CompletedProcess[bytes]:
    """Run a program to its end."""
    return subprocess.run(
        [*TIMONEL, *arguments], input=stdin, capture_output=True, env=ENVIRONMENT, timeout=60, check=False
    )


def start(*arguments: str) -> subprocess.Popen[bytes]:
    """Start a program that runs until it is stopped."""
    return subprocess.Popen([*TIMONEL, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT)
