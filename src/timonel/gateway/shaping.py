"""What an owner may say of one port: which sentences, as whose, how often, and how many bytes a second."""

from collections.abc import Callable, Iterable
from typing import Annotated, Any

import msgspec

from timonel.core.mistakes import did_you_mean, written
from timonel.links import urls
from timonel.links.link import ByteLink
from timonel.links.shaped import Shaped
from timonel.nmea0183.ration import Ration
from timonel.nmea0183.registry import SENTENCES
from timonel.nmea0183.selection import Hearing, Selection, Selector
from timonel.vehicles.boat.conversion import RATES
from timonel.vehicles.boat.settings import Hertz

KEYS: dict[str, Any] = {
    "sentences": list[str],
    "except": list[str],
    "talker": str | dict[str, str],
    "rates": dict[str, Hertz],
    "bytes_per_second": Annotated[int, msgspec.Meta(ge=100, le=10_000_000)],
}
"""Keys of a `[[station]]` and an `[[output]]`."""

HEARING_KEYS: dict[str, Any] = {"sentences": list[str], "except": list[str], "talkers": list[str]}
"""Keys of an `[[input]]`."""

WORDS = frozenset({"PARP"})
AIS = frozenset({"VDM", "VDO"})
ALERTS = frozenset({"ALR", "ALF", "ALC", "ARC", "HBT"})
KNOWN = frozenset(name.decode() for name in SENTENCES) | RATES.keys() | WORDS | AIS | ALERTS
UNPACED = WORDS | AIS | ALERTS
"""Each of these tells something that no later one tells again."""

BITS_A_BYTE = 10  # 8N1

Wrong = Callable[[str, str], None]


def settle(values: dict[str, Any], place: str, station: bool, wrong: Wrong) -> Selection:
    """The selection in the sound `values` of a table; what is wrong all the same is told to `wrong`."""
    only, but, rates = values.get("sentences"), values.get("except", []), values.get("rates", {})
    talker = values.get("talker")
    talkers = talker if isinstance(talker, dict) else {}
    for key, names in (("sentences", only or ()), ("except", but), ("rates", rates), ("talker", talkers)):
        _check_names(f"{place}.{key}", names, wrong)
    if only is not None and but:
        wrong(f"{place}.except", "sentences says already which ones; leave one of them out")
    if station and (hidden := sorted((WORDS | ALERTS) & set(but))):
        wrong(f"{place}.except", f"{written(hidden[0])} must reach a station: it says who steers, or what is wrong")
    for name in sorted(UNPACED & rates.keys()):
        wrong(f"{place}.rates", f"{written(name)} has no rate: each one tells something of its own")
    codes = talkers.values() if isinstance(talker, dict) else () if talker is None else (talker,)
    _check_talkers(f"{place}.talker", codes, wrong)
    return Selection(
        None if only is None else tuple(only),
        tuple(but),
        talker if isinstance(talker, str) else None,
        talkers,
        rates,
    )


def hearing(values: dict[str, Any], place: str, wrong: Wrong) -> Hearing | None:
    """What is heard of an input, of the sound `values` of its table; None is all of it."""
    only, but, talkers = values.get("sentences"), values.get("except", []), values.get("talkers")
    if only is None and talkers is None and not but:
        return None
    _check_names(f"{place}.sentences", only or (), wrong, "that we read")
    if only is not None and but:
        wrong(f"{place}.except", "sentences says already which ones; leave one of them out")
    _check_talkers(f"{place}.talkers", talkers or (), wrong)
    return Hearing(None if only is None else tuple(only), tuple(but), None if talkers is None else tuple(talkers))


def _check_talkers(key: str, codes: Iterable[str], wrong: Wrong) -> None:
    for code in codes:
        if not (len(code) == 2 and code.isascii() and code.isalpha() and code.isupper()):
            wrong(key, f"{written(code)} is not a talker: two capital letters, as GP, II or HE")


def _check_names(key: str, names: Iterable[str], wrong: Wrong, known: str = "that we send") -> None:
    for name in names:
        if name not in KNOWN:
            wrong(key, f"{written(name)} is no sentence {known}{did_you_mean(name, KNOWN)}")


def shaped(port: ByteLink, selection: Selection, bytes_per_second: int | None, station: bool) -> ByteLink:
    """`port`, on which only the selection goes out, and no more than so much or than a serial line carries.

    Itself where there is nothing to hold back.
    """
    rate = bytes_per_second or _of_line(port.url)
    if selection.all and rate is None:
        return port
    selector = None if selection.all else Selector(selection, urgent_passes=station)
    return Shaped(port, selector, None if rate is None else Ration(rate))


def _of_line(url: str) -> int | None:
    """What a serial line carries, None for all else."""
    baud = urls.parse(url).values.get("baud", urls.BAUD)
    return int(str(baud)) // BITS_A_BYTE if url.startswith("serial://") else None
