"""What Signal K is told: some values at once, from one source."""

import msgspec

Value = float | int | str | bool | dict[str, object] | list[str] | None
Values = dict[str, Value]

OWN = "timonel"
"""The label of our sources: alone for what we say ourselves, with an address for what a device on the bus says."""


class Told(msgspec.Struct, frozen=True, gc=False):
    """Values by path that belong together: the newest of a `key` replaces the one before it.

    `heard` is when `source` told them, s of the machine's time; None for a state, which holds until it is another.
    """

    key: str
    source: str
    heard: float | None
    values: Values
