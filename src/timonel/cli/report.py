"""Summaries of recordings as tables, for people."""

import os
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from timonel.recording.summary import LOSSES, Device, Summary, Tally

UNREADABLE_SHOWN = 10

_NUMBERS = {"frames", "messages", "PGNs", "sources", "lost", "unreadable", "count", "a second"}
_WIDE = 160  # characters of a line where it is no terminal that decides


def console(stderr: bool = False) -> Console:
    """Of the terminal's width, or wide enough for a file."""
    made = Console(stderr=stderr, highlight=False)
    return made if made.is_terminal else Console(stderr=stderr, highlight=False, width=_WIDE)


def overview(summaries: Sequence[Summary], console: Console) -> None:
    """Of one recording what is known of it, of several a line each."""
    if len(summaries) == 1:
        console.print(_facts(summaries[0]))
        console.print(devices(summaries[0].devices))
    else:
        names = ("file", "format", "begins", "lasts", "frames", "messages", "PGNs", "sources", "lost", "unreadable")
        console.print(table(names, map(_line, summaries)))
    for summary in summaries:
        unreadable(summary, console)


def details(summary: Summary, console: Console) -> None:
    """All that is known without decoding: facts, messages, devices."""
    console.print(_facts(summary))
    console.print(messages(summary.messages))
    console.print(devices(summary.devices))
    unreadable(summary, console)


def _line(summary: Summary) -> list[str]:
    counts = (
        summary.frames,
        summary.count,
        len({key for key, _ in summary.messages}),
        len(summary.devices),
        summary.lost,
        summary.unreadable_count,
    )
    return [os.path.basename(summary.file), summary.format, begin(summary), span(summary.seconds), *map(number, counts)]


def _facts(summary: Summary) -> Table:
    facts = Table.grid(padding=(0, 2))
    dates = "" if summary.dated else ", times without a date" if summary.timed else ", no times"
    kinds = len({key for key, _ in summary.messages})
    for name, value in (
        ("file", summary.file),
        ("format", summary.format + dates),
        ("begins", begin(summary)),
        ("lasts", span(summary.seconds)),
        ("frames", number(summary.frames) + _per_second(summary.frames, summary.seconds)),
        ("messages", number(summary.count) + _per_second(summary.count, summary.seconds)),
        ("of", f"{kinds} PGNs from {len(summary.devices)} sources"),
        ("fast packets", losses(summary)),
        ("unreadable", number(summary.unreadable_count)),
    ):
        facts.add_row(Text(name, "dim"), Text(value, overflow="fold"))
    return facts


def messages(tallies: dict[tuple[int, str | None], Tally]) -> Table:
    """What is sent how often."""
    rows = []
    for (key, name), tally in sorted(tallies.items(), key=_by_number):
        rate = "" if tally.rate is None else f"{tally.rate:.3g}" if tally.rate < 1000 else f"{tally.rate:.0f}"
        kind = f"frame {-1 - key}" if key < 0 else str(key)
        rows.append([kind, name or "unknown", number(tally.count), rate, "" if tally.title == name else tally.title])
    return table(("PGN", "message", "count", "a second", "what it is"), rows)


def _by_number(item: tuple[tuple[int, str | None], Tally]) -> tuple[int, str]:
    (key, name), _ = item
    return key, name or ""


def devices(found: dict[int, Device]) -> Table:
    """Who sends, and what they said of themselves."""
    names = ("source", "messages", "maker", "function", "product", "software", "serial number", "NAME")
    return table(names, (_device(address, device) for address, device in sorted(found.items())))


def _device(address: int, device: Device) -> list[str]:
    claim, product = device.claim or {}, device.product or {}
    return [
        str(address),
        number(device.messages),
        _said(claim, "manufacturerCode"),
        _said(claim, "deviceFunction") or _said(claim, "deviceClass"),
        _said(product, "modelId"),
        _said(product, "softwareVersionCode"),
        _said(product, "modelSerialCode"),
        device.name or "",
    ]


def unreadable(summary: Summary, console: Console) -> None:
    """The first things that could not be read, with their places."""
    for found in summary.unreadable[:UNREADABLE_SHOWN]:
        console.print(f"{summary.file}, {found.place}: {found.reason}: {found.text}", markup=False, highlight=False)
    if (more := summary.unreadable_count - UNREADABLE_SHOWN) > 0:
        console.print(f"{summary.file}: {more} more could not be read", markup=False, highlight=False)


def losses(summary: Summary) -> str:
    """What became of the fast packets."""
    counters = summary.counters
    lost = [f"{getattr(counters, name)} {name}" for name in LOSSES if getattr(counters, name)]
    return ", ".join([f"{number(counters.completed)} whole", *lost])


def begin(summary: Summary) -> str:
    """The time of the first message: UTC, or as it stands where there is no date."""
    if summary.first is None:
        return "no times"
    moment = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=summary.first // 1000)
    text = f"{moment:%Y-%m-%d %H:%M:%S}.{moment.microsecond // 1000:03}"
    return f"{text} UTC" if summary.dated else f"{text[11:]}, no date"


def span(seconds: float | None) -> str:
    """A time for people: `59.998 s`, `1 h 02 min 03 s`."""
    if seconds is None:
        return ""
    if seconds < 60:
        return f"{seconds:.3f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    parts = ((days, "{} d"), (hours, "{} h"), (minutes, "{:02} min" if hours or days else "{} min"), (rest, "{:02} s"))
    return " ".join(form.format(value) for value, form in parts if value or "02" in form)


def number(value: int) -> str:
    """With a blank between thousands."""
    return f"{value:,}".replace(",", " ")


def _per_second(count: int, seconds: float | None) -> str:
    return f", {count / seconds:.4g} a second" if seconds else ""


def _said(fields: dict[str, Any], name: str) -> str:
    return str(fields.get(name, ""))


def table(names: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Without the columns in which nothing stands."""
    rows = list(rows)
    made = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    shown = [place for place in range(len(names)) if any(row[place] for row in rows)]
    for place in shown:
        made.add_column(names[place], justify="right" if names[place] in _NUMBERS else "left", overflow="fold")
    for row in rows:
        made.add_row(*(Text(row[place]) for place in shown))
    return made


def plain(summary: Summary) -> dict[str, Any]:
    """The same for programs, as JSON takes it."""
    return {
        "file": summary.file,
        "format": summary.format,
        "timed": summary.timed,
        "dated": summary.dated,
        "first": None if summary.first is None else summary.first // 1000 / 1e6,
        "last": None if summary.last is None else summary.last // 1000 / 1e6,
        "frames": summary.frames,
        "unreadable": summary.unreadable_count,
        "fast_packets": {name: getattr(summary.counters, name) for name in ("completed", *LOSSES)},
        "messages": [
            {"frame" if key < 0 else "pgn": -1 - key if key < 0 else key, "name": name, "count": tally.count,
             "rate": tally.rate}
            for (key, name), tally in sorted(summary.messages.items(), key=_by_number)
        ],
        "sources": {
            str(address): {"messages": device.messages, "name": device.name, "claim": device.claim,
                           "product": device.product}
            for address, device in sorted(summary.devices.items())
        },
    }  # fmt: skip
