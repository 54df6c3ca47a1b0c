"""`timonel demo` for a browser: started, killed and started again on the same port."""

import os
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path

from tests.program import Program, free_port


def busy() -> float:
    """How many times as long as on an idle computer things take now: what else it does is no fault of ours."""
    return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))


def wait_until(condition: Callable[[], object], what: str, within: float = 10.0) -> float:
    """Wait for it and tell how long it took, s; fail when it does not come."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < within, f"not within {within:g} s: {what}"
        time.sleep(0.01)
    return time.monotonic() - began


class Demo:
    """A simulated vehicle with its gateway and its console at `url`; pseudo-terminals are in `directory`."""

    def __init__(self, directory: Path, vehicle: str, *options: str) -> None:
        self.directory = directory
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}/"
        arguments = ("--no-view", "--no-recording", "--directory", str(directory), "--port", str(_pair()))
        self.program = Program(directory, "demo", vehicle, *arguments, "--web-port", str(self.port), *options)

    def start(self) -> None:
        """Start it and wait until it serves."""
        self.program.start()
        wait_until(lambda: serves(self.program, self.url), "the console is served", 30.0)

    def stop(self) -> None:
        """As a power cut would."""
        self.program.kill()


def serves(program: Program, url: str) -> bool:
    """Whether a program that runs serves its console at `url`."""
    assert not program.ended, program.log_path.read_text()
    try:
        with urllib.request.urlopen(f"{url}api/v1/about", timeout=2) as answer:
            return bool(answer.status == 200)
    except (urllib.error.URLError, OSError):
        return False


def _pair() -> int:
    """The first of five TCP ports in a row, as the boat wants them."""
    return min(free_port(), 65000)
