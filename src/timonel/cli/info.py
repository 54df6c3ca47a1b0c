"""`timonel info`: what recordings have, without decoding them."""

import gc

import click
import msgspec

from timonel.cli import report
from timonel.cli.many import Tell, Work, carry_out
from timonel.recording.decoding import Pass
from timonel.recording.summary import Summary


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="For programs: one line of JSON a file.")
@click.option("--jobs", type=click.IntRange(1), help="Files at a time; as many as there are processors, if not given.")
def info(files: tuple[str, ...], as_json: bool, jobs: int | None) -> None:
    """Tell what FILES have: format, times, messages and how often they come, who sends them, what was lost."""
    gc.freeze()  # what is loaded stays: not looked through for garbage, in the end neither
    outcome = carry_out([Work(file, _summary) for file in files], jobs)
    screen = report.Screen()
    for summary in outcome.results:
        if as_json:
            click.echo(msgspec.json.encode(report.plain(summary)))
        else:
            report.details(summary, screen)
    outcome.leave()


def _summary(file: str, tell: Tell) -> Summary:
    recording = Pass(file)
    for _ in recording:
        tell(recording.log.bytes_read)
    return recording.summary
