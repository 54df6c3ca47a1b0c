"""`timonel decode`: recordings to JSON lines, CSV, Arrow or Parquet."""

import gc
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

import click
import msgspec

from timonel.cli.many import Tell, Work, carry_out
from timonel.recording.decoding import Pass
from timonel.recording.summary import Summary
from timonel.recording.wanted import wanted
from timonel.vehicles.rover.protocol import Protocol

STDOUT = "-"


class Options(msgspec.Struct, frozen=True):
    """What is wanted of a recording, and where it goes: a file, a directory, or `STDOUT`."""

    kind: str
    where: str
    words: tuple[str, ...] = ()
    frames: str | None = None
    labels: bool = True
    strict: bool = False
    date: int | None = None


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option(
    "--to", "kind", type=click.Choice(["jsonl", "csv", "arrow", "parquet"]), default="jsonl", show_default=True
)
@click.option("-o", "--output", type=click.Path(), help="Where to: a file, or a directory with a file a message.")
@click.option("-m", "--message", "--pgn", "words", multiple=True, help="Only this message: its name, PGN or frame.")
@click.option("--frames", type=click.Path(), help="A TOML or Python file with frames of one's own rover.")
@click.option("--lookups", type=click.Choice(["label", "code"]), default="label", show_default=True)
@click.option("--date", type=click.DateTime(["%Y-%m-%d"]), help="The first day, where a recording has times only.")
@click.option("--strict", is_flag=True, help="Stop at the first thing that cannot be read.")
@click.option("--jobs", type=click.IntRange(1), help="Files at a time; as many as there are processors, if not given.")
def decode(
    files: tuple[str, ...],
    kind: str,
    output: str | None,
    words: tuple[str, ...],
    frames: str | None,
    lookups: str,
    date: datetime | None,
    strict: bool,
    jobs: int | None,
) -> None:
    """Decode FILES, recordings of a bus in any format, of canboat's whole database and of a rover.

    JSON lines go to standard output in the order of the recording, a line a message. CSV, Arrow and Parquet have a
    file a message in a directory (-o), one directory a recording if there are several. Values are SI; what is not
    available is left out, or null. - is standard input, decoded as it comes.
    """
    gc.freeze()  # what is loaded stays: not looked through for garbage, in the end neither
    wanted(words, _protocol(frames))
    day = None if date is None else int(date.replace(tzinfo=UTC).timestamp()) * 1_000_000_000
    options = Options(kind, output or STDOUT, words, frames, lookups == "label", strict, day)
    if output and any(
        os.path.exists(output) and os.path.exists(file) and os.path.samefile(output, file) for file in files
    ):
        raise click.UsageError(f"{output} is a recording itself")
    if kind == "jsonl":
        _lines(files, options, jobs)
    else:
        _tables(files, options, jobs)


def _lines(files: Sequence[str], options: Options, jobs: int | None) -> None:
    """One after the other to one place, or each to its own file in a directory."""
    directory = Path(options.where)
    if options.where != STDOUT and (directory.is_dir() or options.where.endswith(os.sep)):
        directory.mkdir(parents=True, exist_ok=True)
        _report(_works(files, options, [str(directory / f"{name}.jsonl") for name in _names(files)]), jobs)
    elif len(files) == 1 or jobs == 1:
        if options.where != STDOUT:
            open(options.where, "wb").close()
        _report(_works(files, options, [options.where] * len(files)), 1)
    else:
        with ExitStack() as stack:
            parts = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="timonel-")))
            places = [str(parts / name) for name in _names(files)]
            output = sys.stdout.buffer if options.where == STDOUT else stack.enter_context(open(options.where, "wb"))
            _report(_works(files, options, places), jobs, lambda: _join(places, output))


def _tables(files: Sequence[str], options: Options, jobs: int | None) -> None:
    if options.where == STDOUT:
        if len(files) > 1 or len(options.words) != 1 or sys.stdout.isatty():
            raise click.UsageError(f"{options.kind} of more than one message or recording needs a directory (-o)")
        _report(_works(files, options, [STDOUT]), 1)
        return
    directory = Path(options.where)
    places = [directory] if len(files) == 1 else [directory / name for name in _names(files)]
    for place in places:
        place.mkdir(parents=True, exist_ok=True)
    _report(_works(files, options, [str(place) for place in places]), jobs)


def _works(files: Sequence[str], options: Options, places: Sequence[str]) -> list[Work[Summary]]:
    function = _to_lines if options.kind == "jsonl" else _to_tables
    return [
        Work(file, function, (msgspec.structs.replace(options, where=place),))
        for file, place in zip(files, places, strict=True)
    ]


def _report(works: Sequence[Work[Summary]], jobs: int | None, then: Callable[[], object] = lambda: None) -> None:
    outcome = carry_out(works, jobs)
    then()
    from timonel.cli import report  # not before something was written: it takes its time

    if outcome.results:
        report.overview(outcome.results, report.Screen(stderr=True))
    outcome.leave()


def _join(places: Sequence[str], output: BinaryIO) -> None:
    for place in places:
        if os.path.exists(place):
            with open(place, "rb") as part:
                shutil.copyfileobj(part, output, 1 << 20)
    output.flush()


def _names(files: Sequence[str]) -> list[str]:
    """What the output of each file is called: as the file, with a number where two have one name."""
    names: list[str] = []
    for file in files:
        name = os.path.basename(file)
        same = sum(known == name or known.startswith(f"{name}~") for known in names)
        names.append(f"{name}~{same + 1}" if same else name)
    return names


def _protocol(frames: str | None) -> Protocol:
    if frames is None:
        return Protocol()
    from timonel.gateway import own_frames

    return Protocol(own=own_frames.load(frames))


# What a process does with a recording ---------------------------------------------------------------


def _to_lines(file: str, tell: Tell, options: Options) -> Summary:
    from timonel.recording.sinks.jsonl import JsonLines

    protocol = _protocol(options.frames)
    choice = wanted(options.words, protocol)
    recording = Pass(file, protocol, choice, options.strict)
    lines = JsonLines(options.labels, recording.day(options.date), protocol, choice.names)
    with ExitStack() as stack:
        output = sys.stdout.buffer if options.where == STDOUT else stack.enter_context(open(options.where, "ab"))
        for chunk in recording:
            output.write(lines.lines(chunk.groups, chunk.first, chunk.frames, chunk.selected))
            output.flush()
            tell(recording.log.bytes_read)
    return recording.summary


def _to_tables(file: str, tell: Tell, options: Options) -> Summary:
    from timonel.recording.sinks.arrow import Choice, Files, write

    protocol = _protocol(options.frames)
    choice = wanted(options.words, protocol)
    recording = Pass(file, protocol, choice, options.strict)
    files = Files(sys.stdout.buffer if options.where == STDOUT else Path(options.where), options.kind)
    return write(recording, files, protocol, Choice(choice.names, options.labels, options.date), tell)
