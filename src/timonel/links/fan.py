"""One batch of lines for many readers, written to one after the other with next to nothing in between.

After a system call the processor has forgotten much of our code, so a statement between two writes costs many times
what it costs elsewhere: with twelve readers, more than a quarter of the writes themselves. So what all readers have in
common is worked out once a batch, and what one reader needs of its own only when it does not take a batch whole:

```
reader                        gets a batch
ready                         by one write from here; what it does not take is its wire's matter
with lines that wait, gone    by its link's own `send`, as without a fan
```
Who is ready is looked up anew when a wire or a link says that something `changed`.
"""

import os
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeGuard

import msgspec

from timonel.core.effects import Say
from timonel.links.kept import Kept
from timonel.links.link import Counters

Send = Callable[[Sequence[Say]], None]


class Outlet(Protocol):
    """A wire, as far as a fan is concerned."""

    fd: int
    tally: Counters

    def refused(self, fault: OSError) -> int:
        """A write failed: 0 bytes went out. If it was not for want of room, the wire is broken now."""

    def keep(self, lines: Sequence[Say], written: int) -> None:
        """Only the first `written` bytes of `lines` went out."""


class Fanned(Protocol):
    """A link that can be served by a fan."""

    fan: "Fan | None"

    def outlets(self) -> tuple[Sequence[Outlet], Sequence[Send]]:
        """Its readers that are ready, and what to send to for the others."""


class Plan(msgspec.Struct, frozen=True):
    """Whom to write to, and whom to send to; `outlets` are those of `fds`."""

    fds: tuple[int, ...]
    outlets: dict[int, Outlet]
    others: tuple[Send, ...]


class Fan:
    """The readers of `links`."""

    def __init__(self, links: Sequence[Fanned]) -> None:
        self._links = links
        self._plan: Plan | None = None
        self._given = 0  # bytes that went to each of the plan, and are not in its tally yet
        for link in links:
            link.fan = self

    # Once a batch, and its loop once a reader.
    def send(self, lines: Sequence[Say]) -> None:
        """Write `lines`, at least one, to every reader; see `ByteLink`."""
        plan = self._plan or self._make_plan()
        data = lines[0].line if len(lines) == 1 else b"".join([say.line for say in lines])
        size = len(data)
        self._given += size
        write = os.write
        for fd in plan.fds:
            try:
                written = write(fd, data)
            except OSError as fault:
                written = plan.outlets[fd].refused(fault)
            if written != size:
                outlet = plan.outlets[fd]
                outlet.tally.bytes_out += written - size
                outlet.keep(lines, written)
        for send in plan.others:
            send(lines)

    def changed(self) -> None:
        """A reader came or left, cannot keep up or can again."""
        self.settle()
        self._plan = None

    def settle(self) -> None:
        """Bring the tallies up to date."""
        given, self._given = self._given, 0
        if self._plan is not None:
            for outlet in self._plan.outlets.values():
                outlet.tally.bytes_out += given

    def _make_plan(self) -> Plan:
        outlets: dict[int, Outlet] = {}
        others: list[Send] = []
        for link in self._links:
            ready, rest = link.outlets()
            outlets.update({outlet.fd: outlet for outlet in ready})
            others += rest
        self._plan = Plan(tuple(outlets), outlets, tuple(others))
        return self._plan


class Served(Kept[bytes]):
    """A link that a fan may serve."""

    fan: Fan | None = None

    @property
    def counters(self) -> Counters:
        if self.fan is not None:
            self.fan.settle()
        return super().counters

    def _tell_fan(self) -> None:
        """Somebody came, left, or can keep up again."""
        if self.fan is not None:
            self.fan.changed()


def is_fanned(link: Any) -> TypeGuard[Fanned]:
    """Whether a link can be served by a fan."""
    return hasattr(link, "outlets")
