"""Summaries of recordings as tables, for people."""

import os
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

from timonel.cli.sheets import Screen as Screen
from timonel.cli.sheets import Sheet
from timonel.cli.sheets import console as console
from timonel.recording.summary import LOSSES, Device, Summary, Tally

if TYPE_CHECKING:
    from rich.table import Table

UNREADABLE_SHOWN = 10

_NUMBERS = frozenset({"frames", "messages", "PGNs", "sources", "lost", "unreadable", "count", "a second"})


def overview(summaries: Sequence[Summary], screen: Screen) -> None:
    """Of one recording what is known of it, of several a line each."""
    if len(summaries) == 1:
        screen.print(_facts(summaries[0]))
        screen.print(devices(summaries[0].devices))
    else:
        names = ("file", "format", "begins", "lasts", "frames", "messages", "PGNs", "sources", "lost", "unreadable")
        screen.print(_sheet(names, map(_line, summaries)))
    for summary in summaries:
        unreadable(summary, screen)


def details(summary: Summary, screen: Screen) -> None:
    """All that is known without decoding: facts, messages, devices."""
    screen.print(_facts(summary))
    screen.print(messages(summary.messages))
    screen.print(devices(summary.devices))
    unreadable(summary, screen)


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


def _facts(summary: Summary) -> Sheet:
    dates = "" if summary.dated else ", times without a date" if summary.timed else ", no times"
    kinds = len({key for key, _ in summary.messages})
    facts = (
        ("file", summary.file),
        ("format", summary.format + dates),
        ("begins", begin(summary)),
        ("lasts", span(summary.seconds)),
        ("frames", number(summary.frames) + _per_second(summary.frames, summary.seconds)),
        ("messages", number(summary.count) + _per_second(summary.count, summary.seconds)),
        ("of", f"{kinds} PGNs from {len(summary.devices)} sources"),
        ("fast packets", losses(summary)),
        ("unreadable", number(summary.unreadable_count)),
    )
    return Sheet((), facts)


def messages(tallies: dict[tuple[int, str | None], Tally]) -> Sheet:
    """What is sent how often."""
    rows = []
    for (key, name), tally in sorted(tallies.items(), key=_by_number):
        rate = "" if tally.rate is None else f"{tally.rate:.3g}" if tally.rate < 1000 else f"{tally.rate:.0f}"
        kind = f"frame {-1 - key}" if key < 0 else str(key)
        rows.append([kind, name or "unknown", number(tally.count), rate, "" if tally.title == name else tally.title])
    return _sheet(("PGN", "message", "count", "a second", "what it is"), rows)


def _by_number(item: tuple[tuple[int, str | None], Tally]) -> tuple[int, str]:
    (key, name), _ = item
    return key, name or ""


def devices(found: dict[int, Device]) -> Sheet:
    """Who sends, and what they said of themselves."""
    names = ("source", "messages", "maker", "function", "product", "software", "serial number", "NAME")
    return _sheet(names, (_device(address, device) for address, device in sorted(found.items())))


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


def unreadable(summary: Summary, screen: Screen) -> None:
    """The first things that could not be read, with their places."""
    for found in summary.unreadable[:UNREADABLE_SHOWN]:
        screen.print(f"{summary.file}, {found.place}: {found.reason}: {found.text}")
    if (more := summary.unreadable_count - UNREADABLE_SHOWN) > 0:
        screen.print(f"{summary.file}: {more} more could not be read")


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


def table(names: Sequence[str], rows: Iterable[Sequence[str]]) -> "Table":
    """Without the columns in which nothing stands."""
    return _sheet(names, rows).__rich__()


def _sheet(names: Sequence[str], rows: Iterable[Sequence[str]]) -> Sheet:
    return Sheet(names, list(rows), _NUMBERS)


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
