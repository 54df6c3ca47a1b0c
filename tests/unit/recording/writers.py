"""Small writers of log formats, so that the readers are tried with what they must give back."""

import base64
import gzip
import io
import struct
from datetime import UTC, datetime

import can
import zstandard

from timonel.nmea2000.identifier import split
from timonel.vehicles.rover.framing import DIALECTS


def clock(stamp):
    return datetime.fromtimestamp(stamp, UTC)


# Lines of frames ----------------------------------------------------------------------------------


def candump(frames):
    return "".join(f"({f.stamp:.6f}) can0 {f.identifier:08X}#{f.data.hex().upper()}\n" for f in frames).encode()


def candump_printed(frames):
    lines = (f"  can0  {f.identifier:08X}   [{len(f.data)}]  {f.data.hex(' ').upper()}\n" for f in frames)
    return "".join(lines).encode()


def yd_raw(frames):
    lines = (f"{clock(f.stamp):%H:%M:%S.%f}"[:-3] + f" R {f.identifier:08X} {f.data.hex(' ')}\r\n" for f in frames)
    return "".join(lines).encode()


def trc_11(frames):
    lines = [";$FILEVERSION=1.1", f";$STARTTIME={frames[0].stamp / 86400 + 25569:.12f}"]
    for number, f in enumerate(frames, 1):
        elapsed = (f.stamp - frames[0].stamp) * 1000
        lines.append(f"{number:>6}) {elapsed:11.1f}  Rx     {f.identifier:08X}  {len(f.data)}  {f.data.hex(' ')} ")
    return "\r\n".join([*lines, ""]).encode()


# Lines of messages --------------------------------------------------------------------------------


def canboat(messages):
    lines = ["# format=FAST\n"]
    for m in messages:
        i = split(m.identifier)
        stamp = f"{clock(m.stamp):%Y-%m-%dT%H:%M:%S.%f}"[:-3]
        lines.append(f"{stamp}Z,{i.priority},{i.pgn},{i.source},{i.destination},{len(m.data)},{m.data.hex(',')}\n")
    return "".join(lines).encode()


def actisense_ascii(messages):
    lines = []
    for m in messages:
        i = split(m.identifier)
        stamp = f"{clock(m.stamp):%H%M%S.%f}"[:-3]
        lines.append(f"A{stamp} {i.source:02X}{i.destination:02X}{i.priority} {i.pgn:05X} {m.data.hex().upper()}\r\n")
    return "".join(lines).encode()


def ikonvert(messages):
    lines = ["$PDGY,000000,3,,5,798,1,0\r\n"]
    for m in messages:
        i = split(m.identifier)
        seconds, milliseconds = divmod(round(m.stamp * 1000), 1000)
        text = base64.b64encode(m.data).decode()
        address = f"{i.pgn},{i.priority},{i.source},{i.destination}"
        lines.append(f"!PDGY,{address},{seconds}.{milliseconds},{text}\r\n")
    return "".join(lines).encode()


def garmin(messages):
    lines = [
        "Sequence #,Timestamp,PGN,Name,Manufacturer,Remote Address,Local Address,Priority,Single Frame,Size,Packet\n"
    ]
    for number, m in enumerate(messages):
        i = split(m.identifier)
        address = f"{i.source},{i.destination},{i.priority},{int(len(m.data) == 8)}"
        text = f"{len(m.data)},0x{m.data.hex().upper()}"
        lines.append(f"{number},{round(m.stamp * 1000)},{i.pgn},Name, of the PGN,Garmin,{address},{text}\n")
    return "".join(lines).encode()


# Actisense ----------------------------------------------------------------------------------------


def bst(kind, content):
    """A message of up to 255 bytes with its check sum."""
    body = bytes((kind, len(content))) + content
    return body + bytes((-sum(body) & 0xFF,))


def bst_d0(content):
    body = b"\xd0" + (3 + len(content)).to_bytes(2, "little") + content
    return body + bytes((-sum(body) & 0xFF,))


def bdtp(message):
    return b"\x10\x02" + message.replace(b"\x10", b"\x10\x10") + b"\x10\x03"


def ebl_tag(content):
    return b"\x1b\x01" + content.replace(b"\x1b", b"\x1b\x1b") + b"\x1b\x0a"


def ebl_time(stamp):
    return ebl_tag(b"\x03" + (round(stamp * 1e6) * 10 + 116_444_736_000_000_000).to_bytes(8, "little"))


def heard(m):
    """BST 93; the time is milliseconds."""
    i = split(m.identifier)
    time = (round(m.stamp * 1000) & 0xFFFFFFFF).to_bytes(4, "little")
    head = bytes((i.priority,)) + i.pgn.to_bytes(3, "little") + bytes((i.destination, i.source)) + time
    return bst(0x93, head + bytes((len(m.data),)) + m.data)


def raw_frame(f):
    """BST 95; the time is milliseconds."""
    return bst(0x95, struct.pack("<HI", round(f.stamp * 1000) & 0xFFFF, f.identifier) + f.data)


def message_d0(m):
    i = split(m.identifier)
    time = (round(m.stamp * 1000) & 0xFFFFFFFF).to_bytes(4, "little")
    pgn = i.pgn.to_bytes(3, "little")
    head = bytes((i.destination, i.source, pgn[0], pgn[1], i.priority << 2 | pgn[2], 0))
    return bst_d0(head + time + m.data)


def ngt1(messages):
    return b"".join(bdtp(heard(m)) for m in messages)


def ngt1_d0(messages):
    return b"".join(bdtp(message_d0(m)) for m in messages)


def ngt1_frames(frames):
    return b"".join(bdtp(raw_frame(f)) for f in frames)


def ebl(messages):
    version = ebl_tag(b"\x01" + (1002).to_bytes(4, "little"))
    return version + b"".join(ebl_time(m.stamp) + bdtp(heard(m)).replace(b"\x1b", b"\x1b\x1b") for m in messages)


def ebl_frames(frames):
    """As the W2K-1 writes it: without check sums."""
    return b"".join(ebl_time(f.stamp) + ebl_tag(b"\x07" + raw_frame(f)[:-1]) for f in frames)


# Captures -----------------------------------------------------------------------------------------

COOKED = {227: b"", 113: b"\0\1\1\x18" + bytes(10) + b"\0\x0c", 276: b"\0\x0c" + bytes(18)}


def can_frame(f):
    return struct.pack(">IB3x", f.identifier | f.extended << 31, len(f.data)) + f.data.ljust(8, b"\0")


def pcap(frames, order="<", nanoseconds=False, link=227):
    magic, second = (0xA1B23C4D, 1e9) if nanoseconds else (0xA1B2C3D4, 1e6)
    parts = [struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, 262144, link)]
    for f in frames:
        packet = COOKED[link] + can_frame(f)
        whole, fraction = int(f.stamp), round(f.stamp % 1 * second)
        parts += [struct.pack(order + "IIII", whole, fraction, len(packet), len(packet)), packet]
    return b"".join(parts)


def block(order, kind, content):
    content += bytes(-len(content) % 4)
    size = struct.pack(order + "I", len(content) + 12)
    return struct.pack(order + "I", kind) + size + content + size


def pcapng(frames, order="<", link=227, ticks=None):
    """`ticks` a second are 10 to its power; None leaves the option out, which means microseconds."""
    options = b"" if ticks is None else struct.pack(order + "HHB3xHH", 9, 1, ticks, 0, 0)
    parts = [
        block(order, 0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1)),
        block(order, 1, struct.pack(order + "HHI", link, 0, 0) + options),
    ]
    for f in frames:
        packet = COOKED[link] + can_frame(f)
        time = round(f.stamp * 10 ** (6 if ticks is None else ticks))
        head = struct.pack(order + "IIIII", 0, time >> 32, time & 0xFFFFFFFF, len(packet), len(packet))
        parts.append(block(order, 6, head + packet))
    return b"".join(parts)


# python-can ---------------------------------------------------------------------------------------


def with_python_can(writer, path, frames):
    """What python-can's writer makes of the frames."""
    with writer(path) as log:
        for f in frames:
            log.on_message_received(
                can.Message(f.stamp, f.identifier, is_extended_id=f.extended, data=f.data, dlc=len(f.data), channel=0)
            )
    return path.read_bytes()


# The rover ----------------------------------------------------------------------------------------


def uart(dialect, frames):
    return b"".join(DIALECTS[dialect].write(f.identifier, f.data) for f in frames)


# Compressed ---------------------------------------------------------------------------------------


def gzipped(data):
    packed = io.BytesIO()
    with gzip.GzipFile(fileobj=packed, mode="wb", mtime=0) as file:
        file.write(data)
    return packed.getvalue()


def zstd(data):
    return zstandard.ZstdCompressor().compress(data)
