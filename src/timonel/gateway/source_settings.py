"""The keys of `[sources]` and `[[correction]]`, and what they come to."""

import re
from collections.abc import Callable, Collection, Sequence
from typing import Any, get_args, get_type_hints

from timonel.core.mistakes import did_you_mean, written
from timonel.vehicles.boat.sources import Correction, SourceSettings, Wanted

Wrong = Callable[[str, str], object]

_HINTS = get_type_hints(SourceSettings, include_extras=True)
_LISTS: tuple[Wanted, ...] = get_args(Wanted)
_OWN = ("hold", "settle", "hdop_limit", "broken", "derive")
KEYS: dict[str, Any] = dict.fromkeys(_LISTS, list[str]) | {key: _HINTS[key] for key in _OWN}
CORRECTION: dict[str, Any] = get_type_hints(Correction, include_extras=True)
NAME = re.compile(r"0[xX][0-9A-Fa-f]{16}")


def settle(
    values: dict[str, Any], corrections: Sequence[dict[str, Any]], ports: Collection[str], wrong: Wrong
) -> SourceSettings:
    """The settings of two tables whose values are sound; `ports` are the names of those with instruments."""
    for datum in _LISTS:
        for number, source in enumerate(values.get(datum, ()), 1):
            _check(source, ports, f"sources.{datum}[{number}]", wrong)
    for number, correction in enumerate(corrections, 1):
        if "source" in correction:
            _check(correction["source"], ports, f"correction[{number}].source", wrong)
        else:
            wrong(f"correction[{number}].source", "missing; whose values are to be corrected: a NAME or a port")
    return SourceSettings(
        order={datum: tuple(values[datum]) for datum in _LISTS if datum in values},
        corrections=tuple(Correction(**correction) for correction in corrections if "source" in correction),
        **{key: values[key] for key in _OWN if key in values},
    )


def _check(source: str, ports: Collection[str], key: str, wrong: Wrong) -> None:
    if source in ports or NAME.fullmatch(source):
        return
    if source[:2] in ("0x", "0X"):
        wrong(key, f"{written(source)} is no NAME: 0x and 16 hexadecimal digits, as `timonel devices` shows it")
    else:
        wrong(key, f"{written(source)} is no port of instruments{did_you_mean(source, ports)}")
