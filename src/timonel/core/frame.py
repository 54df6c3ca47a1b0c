"""A CAN frame."""

import msgspec


class Frame(msgspec.Struct, frozen=True, gc=False):
    """A classic CAN data frame: `identifier` of 29 bits (11 if not `extended`) and 0..8 bytes of data."""

    identifier: int
    data: bytes
    extended: bool = True
