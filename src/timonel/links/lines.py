"""Whole lines out of the bytes of one client among several on a port."""

from timonel.links.link import Counters

LONGEST = 1024


class WholeLines:
    """Holds back a client's unfinished line, so that the lines of two clients are never mixed.

    A line that grows beyond 1 KiB is dropped up to its end and counted as rejected.
    """

    def __init__(self, tally: Counters) -> None:
        self._tally = tally
        self._unfinished = b""
        self._skipping = False

    def receive(self, data: bytes) -> bytes:
        """All lines that `data` finishes, with their ends; `b""` if none."""
        if self._skipping:
            _, end, data = data.partition(b"\n")
            self._skipping = not end
        data = self._unfinished + data
        whole = data.rfind(b"\n") + 1
        self._unfinished = data[whole:]
        if len(self._unfinished) > LONGEST:
            self._tally.rejected += 1
            self._unfinished = b""
            self._skipping = True
        return data[:whole]
