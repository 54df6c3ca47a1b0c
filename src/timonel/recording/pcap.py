"""CAN in pcap and pcapng, as tcpdump, dumpcap and Wireshark capture it from SocketCAN.

    link type                what stands before the CAN frame
    227  SocketCAN           nothing
    113  Linux cooked        16 bytes, of which the last two are the protocol: 12 is CAN
    276  Linux cooked v2     20 bytes, of which the first two are the protocol

    identifier in network order (bit 31: of 29 bits, 30: remote request, 29: error), length, 3 bytes, data

The three bytes are not always zero, so it is the size of a packet that tells CAN FD, not the flags among them.
Packets of other protocols and interfaces, remote requests and error frames are passed over. Source: tcpdump.org,
Link-layer header types; draft-ietf-opsawg-pcap; draft-ietf-opsawg-pcapng.
"""

from struct import Struct, unpack_from
from typing import NamedTuple

from timonel.recording.blocks import Blocks, Results
from timonel.recording.lines import Kind, LogFrame, moment
from timonel.recording.strays import unreadable_bytes

LINKS = {227: (0, None), 113: (16, 14), 276: (20, 0)}
"""Link types of CAN: the size of what stands before the frame, and where in it the protocol is."""

_CAN = (12).to_bytes(2, "big")
_EXTENDED, _REMOTE_OR_ERROR = 0x80000000, 0x60000000
_FRAME = Struct(">IB3x")
_CLASSIC = 16  # bytes of a frame with its padding; one of CAN FD has 72

_ORDERS = {b"\xd4\xc3\xb2\xa1": "<", b"\xa1\xb2\xc3\xd4": ">", b"\x4d\x3c\xb2\xa1": "<", b"\xa1\xb2\x3c\x4d": ">"}
_NANOSECONDS = (b"\x4d\x3c\xb2\xa1", b"\xa1\xb2\x3c\x4d")
_FILE_HEADER = 24
_LONGEST_PACKET = 262_144  # libpcap's largest snap length

_SECTION = 0x0A0D0D0A.to_bytes(4, "big")
_SECTION_ORDERS = {b"\x4d\x3c\x2b\x1a": "<", b"\x1a\x2b\x3c\x4d": ">"}
_LONGEST_BLOCK = 1 << 24
_RESOLUTION, _OFFSET = 9, 14  # options of an interface


class Pcap(Blocks):
    """pcap: a header, then packets."""

    name = "pcap"
    kind: Kind = "frames"
    dated = True
    HEAD = 16

    @staticmethod
    def recognises(head: bytes) -> bool:
        return head[:4] in _ORDERS

    def __init__(self, head: bytes) -> None:
        super().__init__(_FILE_HEADER)
        order = _ORDERS[head[:4]]
        self._second = 1e9 if head[:4] in _NANOSECONDS else 1e6
        self._packet = Struct(order + "IIII")
        self._link = unpack_from(order + "I", head, 20)[0] & 0xFFFFFFF if len(head) >= _FILE_HEADER else 227
        if self._link not in LINKS:
            raise ValueError(f"pcap of link type {self._link}: CAN has {', '.join(map(str, LINKS))}")

    def _size(self, data: bytes, at: int) -> int:
        _, _, captured, _ = self._packet.unpack_from(data, at)
        return self.HEAD + captured if captured <= _LONGEST_PACKET else 0

    def _block(self, block: bytes, at: int) -> Results:
        seconds, fraction, _, _ = self._packet.unpack_from(block)
        frame = _frame(seconds + fraction / self._second, self._link, block[self.HEAD :])
        if frame is not None:
            yield frame


class _Interface(NamedTuple):
    link: int
    ticks: int
    """In a second."""
    offset: int
    """s"""


class PcapNg(Blocks):
    """pcapng: sections of blocks, among them interfaces and their packets."""

    name = "pcapng"
    kind: Kind = "frames"
    dated = True
    HEAD = 12

    @staticmethod
    def recognises(head: bytes) -> bool:
        return head[:4] == _SECTION and head[8:12] in _SECTION_ORDERS

    def __init__(self, head: bytes) -> None:
        super().__init__()
        self._order = _SECTION_ORDERS[head[8:12]]
        self._interfaces: list[_Interface] = []
        self._links: set[int] = set()

    def finish(self) -> Results:
        yield from super().finish()
        if self._links and self._links.isdisjoint(LINKS):
            yield unreadable_bytes(0, b"", f"no interface of CAN, but of link type {', '.join(map(str, self._links))}")

    def _size(self, data: bytes, at: int) -> int:
        kind = data[at : at + 4]
        if kind == _SECTION:
            self._order = _SECTION_ORDERS.get(data[at + 8 : at + 12], self._order)
        size: int = unpack_from(self._order + "I", data, at + 4)[0]
        return size if size <= _LONGEST_BLOCK and size % 4 == 0 else 0

    def _block(self, block: bytes, at: int) -> Results:
        order = self._order
        kind, size = unpack_from(order + "II", block)
        if unpack_from(order + "I", block, size - 4)[0] != size:
            raise ValueError("a block whose two sizes differ")
        match kind:
            case 0x0A0D0D0A:  # a section
                self._interfaces = []
            case 1:  # an interface
                interface = _interface(order, block[8:-4])
                self._links.add(interface.link)
                self._interfaces.append(interface)
            case 6:  # a packet
                number, high, low, captured, _ = unpack_from(order + "5I", block, 8)
                yield from self._packet(number, high << 32 | low, block[28 : 28 + captured])
            case 3:  # a packet without a time
                (length,) = unpack_from(order + "I", block, 8)
                yield from self._packet(0, None, block[12 : min(12 + length, size - 4)])
            case 2:  # a packet as it was before
                number, _, high, low, captured, _ = unpack_from(order + "2H4I", block, 8)
                yield from self._packet(number, high << 32 | low, block[28 : 28 + captured])

    def _packet(self, number: int, ticks: int | None, packet: bytes) -> Results:
        if number >= len(self._interfaces):
            raise ValueError(f"a packet of interface {number}, which was not described")
        interface = self._interfaces[number]
        if interface.link not in LINKS:
            return
        stamp = None if ticks is None else interface.offset + ticks / interface.ticks
        frame = _frame(stamp, interface.link, packet)
        if frame is not None:
            yield frame


def _interface(order: str, block: bytes) -> _Interface:
    (link,) = unpack_from(order + "H", block)
    ticks, offset, at = 1_000_000, 0, 8
    while at + 4 <= len(block):
        option, length = unpack_from(order + "HH", block, at)
        value = block[at + 4 : at + 4 + length]
        if option == 0:
            break
        if option == _RESOLUTION and length == 1:
            ticks = 2 ** (value[0] & 127) if value[0] & 128 else 10 ** value[0]
        elif option == _OFFSET and length == 8 == len(value):
            (offset,) = unpack_from(order + "q", value)
        at += 4 + length + -length % 4
    return _Interface(link, ticks, offset)


def _frame(stamp: float | None, link: int, packet: bytes) -> LogFrame | None:
    """The frame of a packet; None if it is of another protocol, or has no data to give."""
    before, protocol = LINKS[link]
    if protocol is not None and packet[protocol : protocol + 2] != _CAN:
        return None
    identifier, length = _FRAME.unpack_from(packet, before)
    if identifier & _REMOTE_OR_ERROR:
        return None
    data = packet[before + _FRAME.size :][:length]
    extended = bool(identifier & _EXTENDED)
    number = identifier & 0x1FFFFFFF
    if length > 8 or len(packet) - before > _CLASSIC or (number >> 11 and not extended):
        raise ValueError("not a classic CAN frame")
    if len(data) != length:
        raise ValueError(f"{length} bytes announced, {len(data)} captured")
    return LogFrame(None if stamp is None else moment(stamp), number, data, extended)
