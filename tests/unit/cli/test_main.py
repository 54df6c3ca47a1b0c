import subprocess
import sys
from importlib import import_module

import click
import pytest

from tests.unit.cli.programs import ENVIRONMENT, timonel
from timonel import __version__
from timonel.cli.main import PROGRAMS, main

HEAVY = ("asyncio", "can", "numpy", "pygeomag", "pynmea2", "rich", "serialx", "timonel.gateway", "timonel.vehicles")


def test_help_names_all_programs() -> None:
    shown = timonel("--help").stdout.decode()
    assert [name for name in PROGRAMS if f"\n  {name} " not in shown] == []


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from timonel.cli.main import main\n"
        "main(['--help'], standalone_mode=False)\n"
        f"print('loaded:', [name for name in {HEAVY} if name in sys.modules])\n"
    )
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, env=ENVIRONMENT, check=True)
    assert shown.stdout.decode().splitlines()[-1] == "loaded: []"


def test_version_is_the_packages() -> None:
    assert timonel("--version").stdout.decode() == f"timonel, version {__version__}\n"


@pytest.mark.parametrize("name", PROGRAMS)
def test_each_program_is_there_with_a_help_of_its_own(name: str) -> None:
    module, _, attribute = PROGRAMS[name][0].partition(":")
    command = getattr(import_module(module), attribute)
    assert isinstance(command, click.Command)
    assert command.name == name
    assert command.help


def test_a_program_that_does_not_exist_is_told() -> None:
    run = timonel("konvert")
    assert run.returncode == 2
    assert b"No such command 'konvert'" in run.stderr


def test_the_entry_point_of_the_package_is_this_group() -> None:
    assert isinstance(main, click.Group)
