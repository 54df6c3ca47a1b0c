"""`timonel`: the programs. Each is imported when it is called, so that help and version come at once."""

import gc
import sys
from importlib import import_module
from typing import Any

import click

from timonel import __version__
from timonel.errors import ConfigError, TimonelError

PROGRAMS = {
    "run": ("timonel.cli.run:run", "Run the gateway that a configuration describes."),
    "devices": ("timonel.cli.devices:devices", "Tell who is on an NMEA 2000 bus, or was in a recording of one."),
    "check": ("timonel.cli.check:check", "Tell everything that is wrong in a configuration."),
    "info": ("timonel.cli.info:info", "Tell what recordings have, without decoding them."),
    "decode": ("timonel.cli.decode:decode", "Decode recordings to JSON lines, CSV, Arrow or Parquet."),
    "sql": ("timonel.cli.sql:sql", "Answer questions about recordings, in SQL."),
    "plot": ("timonel.cli.plot:plot", "Draw values of a recording over time, as a page."),
    "track": ("timonel.cli.track:track_program", "Draw where a recording was, as a page, or write it as GPX."),
    "convert": ("timonel.cli.convert:convert", "Turn a recording of a bus into NMEA 0183."),
    "replay": ("timonel.cli.replay:replay", "Verify a recording, or play it to a bus or to listeners."),
    "repair": ("timonel.cli.repair:repair", "Make a recording sound that was cut off."),
    "export": ("timonel.cli.export:export", "Write the layout of the rover's frames for the tools of others."),
    "demo": ("timonel.cli.demo:demo", "Run the gateway on a simulated boat or rover."),
    "pilots": ("timonel.cli.pilots:pilots", "Tell which pilots can be steered, how we know, and which the bus has."),
    "station": ("timonel.cli.station:station", "Be a helm station, with the keyboard."),
    "drive": ("timonel.cli.drive:drive", "Drive a rover, with the keyboard or a gamepad."),
}

EXTRAS = {"numpy": "columns", "pyarrow": "columns", "duckdb": "sql"}
"""What a program may need, and what it is installed with."""


class Programs(click.Group):
    """Subcommands that are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(PROGRAMS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in PROGRAMS:
            return None
        module, _, name = PROGRAMS[cmd_name][0].partition(":")
        gc.disable()  # what is loaded stays: there is no garbage in it
        try:
            command: click.Command = getattr(import_module(module), name)
        except ModuleNotFoundError as missing:
            extra = EXTRAS.get(missing.name or "")
            if extra is None:
                raise
            raise click.ClickException(
                f"{cmd_name} needs the extra `{extra}` (pip install 'timonel[{extra}]')"
            ) from missing
        finally:
            gc.enable()
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in PROGRAMS.items()])

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except TimonelError as error:
            click.echo(error, err=True)
            sys.exit(2 if isinstance(error, ConfigError) else 1)


@click.group(cls=Programs, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="timonel")
def main() -> None:
    """The command gateway between stations and the CAN bus of a boat or rover."""
