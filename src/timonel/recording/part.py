"""Messages of one kind in columns, and how several such lots become one."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.recording.frames import Identifiers

Rows = npt.NDArray[np.intp]
Payloads = npt.NDArray[np.uint8]
Lengths = npt.NDArray[np.intp]


STANDARD = 1 << 18
"""Channels from here on are standard identifiers."""

FIRST_FAST = 0x1ED00
"""No PGN below this one travels as fast packet."""


class Part(msgspec.Struct, frozen=True, eq=False, gc=False):
    """Messages of one `channel`, which is a PGN, or `STANDARD` + a standard identifier.

    `row` is the place in the chunk of the frame that completed each message, in rising order.

    Of `payloads` uint8[n, width], the bytes behind a message's length mean nothing.
    """

    channel: int
    row: Rows
    identifier: Identifiers
    payloads: Payloads
    lengths: Lengths


def merged(parts: Sequence[Part]) -> Part:
    """All of them, in the order of their frames."""
    if len(parts) == 1:
        return parts[0]
    widths = {part.payloads.shape[1] for part in parts}
    payloads = [part.payloads if len(widths) == 1 else _padded(part.payloads, max(widths)) for part in parts]
    whole = Part(
        parts[0].channel,
        np.concatenate([part.row for part in parts]),
        np.concatenate([part.identifier for part in parts]),
        np.concatenate(payloads),
        np.concatenate([part.lengths for part in parts]),
    )
    if all(part.row[-1] < following.row[0] for part, following in pairwise(parts)):
        return whole
    order = np.argsort(whole.row, kind="stable")
    return Part(whole.channel, *(column[order] for column in msgspec.structs.astuple(whole)[1:]))


def _padded(payloads: Payloads, width: int) -> Payloads:
    padded = np.zeros((len(payloads), width), np.uint8)
    padded[:, : payloads.shape[1]] = payloads
    return padded


def of_messages(channel: int, messages: Sequence[tuple[int, int, bytes]]) -> Part:
    """From (row, identifier, payload) of each."""
    rows, identifiers, payloads = zip(*messages, strict=True)
    lengths = np.array([len(payload) for payload in payloads], np.intp)
    width = int(lengths.max())
    cells = np.frombuffer(b"".join(payload.ljust(width, b"\0") for payload in payloads), np.uint8)
    identifier = np.array(identifiers, np.uint32)
    return Part(channel, np.array(rows, np.intp), identifier, cells.reshape(len(rows), width), lengths)


def pgns_of(identifier: Identifiers) -> npt.NDArray[np.uint32]:
    """The PGNs of extended identifiers."""
    pgn = identifier >> 8 & 0x3FFFF
    return np.where(pgn & 0xFF00 < 0xF000, pgn & 0x3FF00, pgn)


def stretches(values: npt.NDArray[Any]) -> Iterator[tuple[int, int]]:
    """Where each stretch of equal values begins and ends."""
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    return pairwise([0, *changes.tolist(), len(values)]) if len(values) else iter(())


def by_key(keys: npt.NDArray[Any], rows: Rows) -> tuple[npt.NDArray[np.uint64], Rows]:
    """Keys in rising order, and with each its row; the rows, which rise, are those of the chunk, the keys of 31 bits.

    Both in one word: to sort words is twice as quick as to find out their order.
    """
    packed = keys.astype(np.uint64)
    packed <<= 32
    packed |= rows.view(np.uint64)
    packed.sort()
    places = (packed & 0xFFFFFFFF).view(np.intp)
    packed >>= 32
    return packed, places


def windows(data: npt.NDArray[np.uint8], begin: Rows, width: int) -> Payloads:
    """uint8[n, width] from each of these places on."""
    all_windows: npt.NDArray[Any] = np.ndarray(len(data) - width + 1, f"V{width}", data, 0, (1,))
    found: Payloads = all_windows[begin].view(np.uint8).reshape(-1, width)
    return found
