"""`strzyga`: the documented framing, `#`, id, data. Nothing in it tells a frame from chance but what follows.

```
behind a frame                                     effect
`#`, after at most four fill bytes 0x00            the frame is proved
silence, or the end, after as many                 the frame is proved
anything else                                      its `#` is dropped
```
So inside a burst a frame comes out with the first byte of the next, and the last one `idle` later.

Changed bits in the data go unnoticed: where the firmware can be changed, `strzyga-crc` is better.

Source: spec/rover.md, Framing without a check sum.
"""

import re

from timonel.errors import EncodeError
from timonel.vehicles.rover.framing.framer import Framer, check

MOST_FILL = 4
"""Fill bytes between two frames that still prove the first."""

_FILL = b"\\x00{0,%d}" % MOST_FILL


class Strzyga(Framer):
    """The parser and writer of the documented framing."""

    FOLLOW = _FILL + b"(?=#)"
    SILENCE = _FILL + rb"(?=#|\Z)"

    @staticmethod
    def write(number: int, data: bytes, pad: int = 0) -> bytes:
        """`#`, id, data, and `pad` fill bytes (0..4).

        Two of them help a naive receiver, which fills up a frame that lost a byte with what comes next: with
        zeros, at rest, instead of the next frame's `#`. A receiver such as ours does without, and better:
        it would take the frame so filled up for a whole one, and drops it otherwise.
        """
        check(number, data, Strzyga.LONGEST)
        if not 0 <= pad <= MOST_FILL:
            raise EncodeError(f"frame {number}: a pad of {pad} is outside 0..{MOST_FILL}")
        return b"#%c%b%b" % (number, data, bytes(pad))

    @staticmethod
    def _id(numbers: bytes) -> bytes:
        return any_byte(numbers)

    @staticmethod
    def _frame(number: bytes, length: int) -> bytes:
        return number + b".{%d}" % length

    @staticmethod
    def _begun(number: bytes, length: int) -> bytes:
        return number + b"(?:.{0,%d}|.{%d}%s)" % (length, length, _FILL)

    @staticmethod
    def _parse(frame: bytes) -> tuple[int, bytes]:
        return frame[0], frame[1:]


def any_byte(numbers: bytes) -> bytes:
    """Pattern of one byte out of `numbers`."""
    return b"[%s]" % re.escape(numbers) if numbers else b"(?!)"
