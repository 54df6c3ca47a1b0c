"""`timonel repair`: a recording that was cut off, made sound."""

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from timonel.gateway.extras import need_recorder

if TYPE_CHECKING:
    from timonel.recording.flight_repair import Repaired


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="The new file; FILE.repaired.mcap if it is not given."
)
def repair(file: Path, output: Path | None) -> None:
    """Write a sound MCAP file, with index and summary, of FILE, which was cut off; say what was lost.

    FILE itself is left as it is. Players and viewers that want an index take the new file; timonel reads either.
    """
    need_recorder()
    from timonel.recording.flight_repair import repair as mend

    target = output or file.with_name(f"{file.name.removesuffix('.mcap')}.repaired.mcap")
    repaired = mend(file, target)
    for damage in repaired.damage:
        if damage.size:
            click.echo(f"{file}: {damage.size} bytes from byte {damage.offset} on are lost: {damage.reason}", err=True)
    click.echo(
        f"{target}: {repaired.messages} messages in {repaired.chunks} chunks{_span(repaired)}, {repaired.size} bytes"
    )


def _span(repaired: "Repaired") -> str:
    if repaired.first_ns is None or repaired.last_ns is None:
        return ""
    return f", {_moment(repaired.first_ns)} to {_moment(repaired.last_ns)}"


def _moment(ns: int) -> str:
    return f"{datetime.fromtimestamp(ns / 1e9, UTC):%Y-%m-%d %H:%M:%S}Z"
