"""What a console of the gateway itself says beside a station's frames: the words that the wire has none for.

```
id    data                                                        effect
240   1 byte: 1 request, 2 release, 3 take, 4 acknowledge, 5 deny    the word about command is heard
241   number of an alert, high byte first                          somebody has seen it
242   the same                                                     it makes no sound for 30 s
```
They are written as `strzyga-crc`, whatever the wires of the rover do: there a frame needs nothing behind it. On a wire
nobody can say them, since its framer does not know their ids. Ids from 240 on are nobody's own (`declared`).
"""

from enum import IntEnum

from timonel.core.command import Verb
from timonel.vehicles.rover.framing.strzyga_crc import StrzygaCrc


class Word(IntEnum):
    """Ids of a console's own frames."""

    COMMAND = 240
    ACKNOWLEDGE = 241
    SILENCE = 242


CONSOLE = {Word.COMMAND: 1, Word.ACKNOWLEDGE: 2, Word.SILENCE: 2}
"""Their lengths in bytes."""
VERBS = {1: Verb.REQUEST, 2: Verb.RELEASE, 3: Verb.TAKE, 4: Verb.ACKNOWLEDGE, 5: Verb.DENY}
NUMBERS = {verb: number for number, verb in VERBS.items()}


class Console(StrzygaCrc):
    """The framing of what a console says."""


def command(verb: Verb) -> bytes:
    """A word about command."""
    return Console.write(Word.COMMAND, bytes((NUMBERS[verb],)))


def acknowledge(alert: int) -> bytes:
    """Somebody has seen the alert with this number."""
    return Console.write(Word.ACKNOWLEDGE, alert.to_bytes(2, "big"))


def silence(alert: int) -> bytes:
    """No sound of the alert with this number for 30 s."""
    return Console.write(Word.SILENCE, alert.to_bytes(2, "big"))
