"""`timonel convert`: a recording of a bus as NMEA 0183."""

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import islice
from typing import TYPE_CHECKING, BinaryIO

import click
from msgspec.structs import replace

from timonel.errors import ConfigError
from timonel.gateway.assemble import boat
from timonel.gateway.configuration import load
from timonel.gateway.convert import Conversion
from timonel.recording import LogFrame, LogReader, open_log
from timonel.vehicles.boat.settings import BoatSettings

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

NULL_ADDRESS = 254  # of whom has none (ISO 11783-5): no device of the recording is taken for ourselves
PROGRESS_EVERY = 4096  # frames
UNREADABLE_SHOWN = 10


@click.command()
@click.argument("log", type=click.Path())
@click.option(
    "--to",
    type=click.Choice(["nmea0183"]),
    default="nmea0183",
    show_default=True,
    expose_value=False,
    help="What to write.",
)
@click.option("-o", "--output", type=click.Path(), default="-", help="Where to; - is standard output, the default.")
@click.option("--config", type=click.Path(), help="A boat.toml whose [vehicle] and [sentences] are used.")
def convert(log: str, output: str, config: str | None) -> None:
    """Turn LOG, a recording of an NMEA 2000 bus, into what the gateway would have said to its stations.

    Its format is told from the content, gzip and zstd too (docs/formats.md lists them); - is standard input. Time is
    the recording's own, so the same recording always gives the same bytes.
    """
    settings = load(config).vehicle if config else BoatSettings()
    if not isinstance(settings, BoatSettings):
        raise ConfigError(f"{config}, vehicle.kind: only what a boat said is converted")
    with ExitStack() as stack:
        reader = stack.enter_context(open_log(log))
        sink = _open_output(stack, output, log)
        conversion = Conversion(boat(replace(settings, address=NULL_ADDRESS), [], 0.0), sink.write)
        conversion.receive(_with_progress(stack, reader) if _watched(output) else reader)
        sink.flush()
    _summarise(reader, conversion)


def _open_output(stack: ExitStack, output: str, log: str) -> BinaryIO:
    if output == "-":
        return sys.stdout.buffer
    if os.path.exists(output) and os.path.exists(log) and os.path.samefile(output, log):
        raise click.UsageError(f"{output} is the recording itself")
    try:
        return stack.enter_context(open(output, "wb"))
    except OSError as fault:
        raise click.FileError(output, fault.strerror) from fault


def _watched(output: str) -> bool:
    """Whether somebody is there to see a progress bar, and sentences do not run through it."""
    return sys.stderr.isatty() and not (output == "-" and sys.stdout.isatty())


def _with_progress(stack: ExitStack, reader: LogReader) -> Iterator[LogFrame]:
    from rich.console import Console
    from rich.progress import Progress

    progress = stack.enter_context(Progress(console=Console(stderr=True), transient=True))
    return _telling(progress.add_task(reader.name, total=reader.size), progress, reader)


def _telling(task: "TaskID", progress: "Progress", reader: LogReader) -> Iterator[LogFrame]:
    entries = iter(reader)
    while some := list(islice(entries, PROGRESS_EVERY)):
        yield from some
        progress.update(task, completed=reader.bytes_read)


def _summarise(reader: LogReader, conversion: Conversion) -> None:
    """What was read and written, and what was not, on standard error."""
    for line in reader.unreadable[:UNREADABLE_SHOWN]:
        _say(f"{reader.name}, {line.place}: {line.reason}: {line.text}")
    if (more := reader.unreadable_count - UNREADABLE_SHOWN) > 0:
        _say(f"{reader.name}: {more} more could not be read")
    time = conversion.time
    for count, what in (
        (time.missing, "without a time: taken as one a millisecond"),
        (time.backward, "with a time before the one before: time stood still"),
        (time.shortened, "after a pause of more than an hour: an hour passed"),
    ):
        if count:
            _say(f"{count} frames {what}")
    for reason, count in conversion.rejected.most_common():
        _say(f"{count} rejected: {reason}")
    written = ", ".join(f"{name} {count}" for name, count in sorted(conversion.sentences.items()))
    _say(
        f"{reader.name}: {reader.format}: {conversion.frames} frames, {conversion.messages} whole messages, "
        f"{time.now:.1f} s; {conversion.sentences.total()} sentences ({written})"
    )


def _say(text: str) -> None:
    click.echo(text, err=True)
