"""Everything that is wrong in a configuration, each with its line and with what would be right."""

import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from operator import itemgetter
from typing import Any

import msgspec
from msgspec import inspect

from timonel.errors import ConfigError

_HEADER = re.compile(r"\s*(\[\[?)([^\[\]#]+)\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")
_LAST = re.compile(r"(\.[^.\[\]]+|\[\d+\])$")
_SYNTAX_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


class Mistakes:
    """Collects what is wrong in one file; true once there is something."""

    def __init__(self, file: str, text: str) -> None:
        self._file = file
        self._lines = dict(_lines_of_keys(text))
        self._found: dict[str, tuple[int, str]] = {}

    def __bool__(self) -> bool:
        return bool(self._found)

    def add(self, key: str, text: str) -> None:
        """Note one mistake a key, written `bus.url`, or `station[2].id` for the second station."""
        line = self._line(key)
        place = f"{self._file}:{line}" if line else self._file
        self._found.setdefault(key, (line or 0, _one_line(f"{place}, {key}: {text}")))

    def _line(self, key: str) -> int | None:
        """Where the key stands, else the table it belongs to, None if neither can be found."""
        while key not in self._lines and (shorter := _LAST.sub("", key)) != key:
            key = shorter
        return self._lines.get(key)

    def error(self) -> ConfigError:
        """All of them in the order of the file."""
        return ConfigError("\n".join(text for _, text in sorted(self._found.values(), key=itemgetter(0))))


def _one_line(text: str) -> str:
    """`text` with an escape for what is not printable: a value may hold a line end or move a terminal's cursor."""
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


def _lines_of_keys(text: str) -> Iterator[tuple[str, int]]:
    """The lines, from 1, of all tables and keys that stand on a line of their own."""
    table = ""
    seen: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line):
            table = _bare(header[2])
            if header[1] == "[[":
                seen[table] = seen.get(table, 0) + 1
                yield table, number
                table = f"{table}[{seen[table]}]"
            yield table, number
        elif key := _KEY.match(line):
            yield f"{table}.{_bare(key[1])}".lstrip("."), number


def _bare(key: str) -> str:
    return ".".join(part.strip().strip("\"'") for part in key.split("."))


def syntax_error(file: str, text: str, fault: ValueError) -> ConfigError:
    """What the TOML parser says, with the place where editors expect it."""
    place = _SYNTAX_PLACE.search(str(fault))
    what = _SYNTAX_PLACE.sub("", str(fault))
    if place is None:
        return ConfigError(f"{file}: {what}")
    line = place[1] or str(max(1, len(text.splitlines())))
    column = f", column {place[2]}" if place[2] else ""
    return ConfigError(f"{file}:{line}{column}: {what[:1].lower()}{what[1:]}")


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """` (did you mean "..."?)` if something known is near, else nothing."""
    names = list(known)
    by_lower_case = {name.lower(): name for name in names}
    near = get_close_matches(str(word).lower(), by_lower_case, n=1)
    return f' (did you mean "{by_lower_case[near[0]]}"?)' if near else ""


def convert(value: object, type_: Any) -> Any:
    """`value` as `type_`; raises ValueError that says what would be right."""
    try:
        return msgspec.convert(value, type_)
    except msgspec.ValidationError:
        wanted = inspect.type_info(type_)
        raise ValueError(f"{written(value)} should be {_wanted(wanted)}{_near(value, wanted)}") from None


def _near(value: object, wanted: inspect.Type) -> str:
    if isinstance(wanted, inspect.LiteralType) and len(wanted.values) > 1:
        return did_you_mean(value, map(str, wanted.values))
    return ""


def written(value: object) -> str:
    """A value as TOML writes it, cut short."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value[:80]}"'
        case dict():
            return "a table"
        case list():
            return "a list"
        case _:
            return str(value)


def _wanted(wanted: inspect.Type) -> str:
    match wanted:
        case inspect.BoolType():
            return "true or false"
        case inspect.IntType(ge=None, le=None):
            return "a whole number"
        case inspect.IntType(ge=ge, le=le):
            return f"a whole number {ge}..{le}"
        case inspect.FloatType(gt=None, ge=None, le=None):
            return "a number"
        case inspect.FloatType(gt=gt, ge=None, le=None):
            return f"a number above {gt}"
        case inspect.FloatType(gt=None, ge=ge, le=le):
            return f"a number {ge}..{le}"
        case inspect.FloatType(gt=gt, le=le):
            return f"a number above {gt}, at most {le}"
        case inspect.TupleType(item_types=items):
            return f"a list of {len(items)}, each {_wanted(items[0])}"
        case inspect.UnionType(types=types):
            return " or ".join(map(_wanted, types))
        case inspect.LiteralType(values=values):
            return " or ".join(f'"{value}"' for value in values)
        case _:
            return "text"
