"""Marks a sentence as simulated: what was recorded must not be taken for what is.

The mode indicator becomes `S`, and with it the status `V` (IEC 61162-1: only modes A, D, F, P and R are valid); the
quality of a GGA becomes 8. What says itself that it is not valid stays as it is, and what has no mode is let through.
"""

from timonel.nmea0183.checksum import seal, verify

MODES = {"RMC": (12, 2), "GLL": (7, 6), "VTG": (9,), "XTE": (6, 1, 2), "RMB": (14, 1), "APB": (15, 1, 2), "THS": (2,)}
"""Which field of a sentence its mode is, and which are its status."""
NOT_VALID = ("N", "V")
GGA_QUALITY, NO_FIX, SIMULATOR = 6, "0", "8"


def simulated(line: bytes) -> bytes:
    """The line, marked; as it is if it is no sentence, or one without a mode.

    Raises EncodeError for an old sentence that has no room for its mode.
    """
    body = verify(line.rstrip(b"\r\n"))
    if not isinstance(body, bytes) or not body.isascii():
        return line
    fields = body.decode().split(",")
    formatter = fields[0][2:]
    if formatter == "GGA" and len(fields) > GGA_QUALITY:
        fields[GGA_QUALITY] = NO_FIX if fields[GGA_QUALITY] in (NO_FIX, "") else SIMULATOR
    elif formatter in MODES and fields[0][0] != "P":
        _mark(fields, *MODES[formatter])
    else:
        return line
    return seal(",".join(fields))


def _mark(fields: list[str], mode: int, *status: int) -> None:
    fields += [""] * (mode + 1 - len(fields))
    if fields[mode] in NOT_VALID:
        return
    fields[mode] = "S"
    for field in status:
        fields[field] = "V"
