"""The page of sentences, derived from their declarations: `python -m timonel.nmea0183.reference`."""

from inspect import getdoc

from timonel.nmea0183.registry import SENTENCES
from timonel.nmea0183.sentence import Sentence, layout
from timonel.nmea0183.sentences import ALC, XDR

HEAD = """# NMEA 0183 sentences

Made by `python -m timonel.nmea0183.reference` from the declarations in `timonel.nmea0183.sentences`.
Any talker is read. An empty field is `None`; a field outside its range makes the sentence malformed. Positive is
north, east, starboard; a cross-track error is positive where the boat must steer left. Times are seconds of the
UTC day.
"""

LISTS: dict[type[Sentence], tuple[str, str]] = {
    ALC: (
        "xx,xx,xx,x,c--c,xxx,x,x ...",
        "`total`, `number`, `sequence`, how many `entries`, and of each manufacturer, number, instance, revision.\n",
    ),
    XDR: ("c--c,x.x,c--c,c--c ...", "`transducers`: any number of type, value, unit and name.\n"),
}
"""Those with any number of fields: notation and table."""


def page() -> str:
    """The page in Markdown."""
    return "\n".join([HEAD, *(_section(kind) for _, kind in sorted(SENTENCES.items()))])


def _section(kind: type[Sentence]) -> str:
    about = " ".join((getdoc(kind) or "").split())
    return f"## {kind.__name__}\n{about}\n\n`{_notation(kind)}`\n\n{_table(kind)}"


def _notation(kind: type[Sentence]) -> str:
    fields = [LISTS[kind][0]] if kind in LISTS else [field.notation for field in layout(kind).values()]
    return f"$--{kind.__name__},{','.join(fields)}*hh"


def _table(kind: type[Sentence]) -> str:
    if kind in LISTS:
        return LISTS[kind][1]
    rows = [f"| `{name}` | `{field.notation}` |" for name, field in layout(kind).items()]
    return "\n".join(["| attribute | field |", "|---|---|", *rows, ""])


if __name__ == "__main__":
    print(page(), end="")
