"""The other programs that do the same work, and how they get here.

The Python packages are in the development environment; npm installs the JavaScript ones, outside the source tree.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import msgspec

HERE = Path(__file__).parent / "peers"
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "timonel-benchmarks"


class Peer(msgspec.Struct, frozen=True):
    """Frames on its standard input, sentences on its standard output."""

    name: str
    command: list[str]


def peers() -> list[Peer]:
    """Those that can be had on this machine."""
    python = Peer("nmea2000 + pynmea2", [sys.executable, str(HERE / "python.py")])
    modules = node_modules()
    if modules is None:
        return [python]
    signalk = [str(shutil.which("node")), str(HERE / "signalk.js"), str(modules)]
    return [python, Peer("canboatjs + n2k-signalk + signalk-to-nmea0183", signalk)]


def node_modules() -> Path | None:
    if not (shutil.which("node") and (npm := shutil.which("npm"))):
        print("without node and npm the Signal K programs are left out", file=sys.stderr)
        return None
    directory = CACHE / "node"
    wanted = HERE / "package.json"
    here = directory / "package.json"
    if not here.exists() or here.read_bytes() != wanted.read_bytes():
        directory.mkdir(parents=True, exist_ok=True)
        shutil.copy(wanted, directory / "new.json")
        here.unlink(missing_ok=True)
        (directory / "new.json").rename(here)
        quiet = ["--ignore-scripts", "--no-audit", "--no-fund", "--silent"]
        if subprocess.run([npm, "install", *quiet], cwd=directory).returncode:
            here.unlink()
            print("npm could not install the Signal K programs; they are left out", file=sys.stderr)
            return None
    return directory / "node_modules"
