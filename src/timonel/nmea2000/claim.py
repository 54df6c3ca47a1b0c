"""Getting an address on the bus, keeping it, and losing it: ISO 11783-5 as NMEA 2000 has it, told the time.

state       what happens                                                  then
BEGINNING   50 ms, in which links open                                    everybody is asked for a claim: SCANNING
SCANNING    250 ms: who is where becomes known                            a free address is claimed: CLAIMING
CLAIMING    250 ms of silence behind the claim                            nobody objected: CLAIMED
CLAIMED     everything else may be sent                                   until the address is lost: CLAIMING
NONE        no address is free: "cannot claim" from 254                   after 10 s a new scan: SCANNING

heard                                           what we do
a claim of our address by a higher NAME         claim it again
a claim of our address by a lower NAME          claim the next free address; none: NONE
a claim by our own NAME                         what we said a second ago comes back; else it is a twin, and its
                                                address tells which of us moves on
    from a lower address, or our own            our device instance moves on by one and the address is claimed anew,
                                                as the Arduino NMEA 2000 library (ttlappalainen) does
    from a higher address                       we claim again, so that it moves on; has it not within 0.5 s, we do
a request for claims                            the claim again, or "cannot claim"
65240 with our NAME                             claim the address that it says

However many of these come, a claim leaves at most every 100 ms on average: those in between are one. The address
that was liked best is tried first, and at its side the next ones up, around 251.
"""

from enum import Enum

from timonel.core.effects import Effect, Event, Transmit
from timonel.core.frame import Frame
from timonel.core.pace import Pace
from timonel.nmea2000.devices import Devices
from timonel.nmea2000.identifier import NULL, join
from timonel.nmea2000.messages.network import IsoRequest
from timonel.nmea2000.sender import Sender, outgoing

CLAIM = 60928
ADDRESSES = 252  # 0..251
SETTLE = 0.05  # s
SCAN = 0.25  # s
SILENCE = 0.25  # s
RETRY = 10.0  # s
CLAIM_INTERVAL = 0.1  # s
ECHO = 1.0  # s within which what we said may come back
TWIN = 0.5  # s in which a twin may move on: were both to move at once, they would be twins again
INSTANCE_AT = 32  # the first of the eight bits of the device instance in a NAME
NEVER = float("inf")


class AddressClaimed(Event, frozen=True, gc=False):
    """The node has this address, under this NAME, and may speak."""

    address: int
    name: int


class AddressLost(Event, frozen=True, gc=False):
    """Another device, whose NAME is lower, has the address now, or we were told to leave it; we look for another."""

    address: int
    by: int


class NoAddress(Event, frozen=True, gc=False):
    """No address is free: nothing can be sent until one is."""


class State(Enum):
    """How far the node is."""

    BEGINNING = "beginning"
    SCANNING = "scanning"
    CLAIMING = "claiming"
    CLAIMED = "claimed"
    NONE = "none"


def with_instance(name: int, instance: int) -> int:
    """The same NAME with another device instance, 0..255."""
    return name & ~(0xFF << INSTANCE_AT) | (instance & 0xFF) << INSTANCE_AT


class Claimer:
    """Claims an address for `name` and moves `sender` to it. `devices` tells which ones are taken."""

    def __init__(self, name: int, preferred: int, sender: Sender, devices: Devices, now: float) -> None:
        self.name = name
        self.state = State.BEGINNING
        self._preferred = preferred
        self._sender = sender
        self._devices = devices
        self._due = now + SETTLE
        self._scanned = now
        self._owed = False
        self._pace = Pace(CLAIM_INTERVAL)
        self._said: dict[tuple[int, int], float] = {}
        self._twin = NULL  # the address of one that is to move on
        self._twin_due = NEVER
        sender.address = NULL

    @property
    def deadline(self) -> float:
        """When `expire` should be called, s."""
        due = min(self._due, self._twin_due)
        return min(due, self._pace.opens) if self._owed else due

    def expire(self, now: float) -> list[Effect]:
        """What the passing of time brings about."""
        effects = self._pay(now)
        if now >= self._twin_due:
            return effects + self._move_on(now)
        if now < self._due:
            return effects
        match self.state:
            case State.SCANNING:
                return effects + self._claim(self._free(self._preferred), now)
            case State.CLAIMING:
                return effects + self._settle(now)
        return effects + self._scan(now)

    def claimed_by(self, name: int, address: int, now: float) -> list[Effect]:
        """Somebody with this NAME claimed an address."""
        if name == self.name:
            return self._met_our_name(address, now)
        if address == self._twin:
            self._twin, self._twin_due = NULL, NEVER
        if address != self._sender.address or address == NULL:
            return []
        if self.name < name:
            return self._say(now)
        return self._lose(address, name, now)

    def asked(self, now: float) -> list[Effect]:
        """Somebody asks who is there."""
        return self._say(now) if self.state in (State.CLAIMING, State.CLAIMED, State.NONE) else []

    def move(self, address: int, now: float) -> list[Effect]:
        """Somebody who may tells us to take this address."""
        if not 0 <= address < ADDRESSES or address == self._sender.address:
            return []
        lost = self._sender.address
        effects = self._claim(address, now)
        return effects if lost == NULL else [AddressLost(lost, by=0), *effects]

    def rename(self, name: int, now: float) -> list[Effect]:
        """From now on our NAME is this; it must be heard, and may lose."""
        self.name = name
        return [] if self._sender.address == NULL else self._claim(self._sender.address, now)

    def announce(self, now: float) -> list[Effect]:
        """The bus was gone and is back: say where we are, and ask who is there."""
        if self.state is not State.CLAIMED:
            return []
        self._scanned = now
        return [*self._say(now), *self._ask()]

    # How it is done -------------------------------------------------------------------------------

    def _scan(self, now: float) -> list[Effect]:
        self.state, self._due, self._scanned = State.SCANNING, now + SCAN, now
        return self._ask()

    def _ask(self) -> list[Effect]:
        return [Transmit(frame) for frame in self._sender.frames(outgoing(IsoRequest(pgn=CLAIM)))]

    def _claim(self, address: int | None, now: float) -> list[Effect]:
        """Try this address; None is that there is none."""
        if address is None:
            self.state, self._due, self._sender.address = State.NONE, now + RETRY, NULL
            return [NoAddress(), *self._say(now)]
        self.state, self._due, self._sender.address = State.CLAIMING, NEVER, address
        return self._say(now)

    def _settle(self, now: float) -> list[Effect]:
        self.state, self._due, self._preferred = State.CLAIMED, NEVER, self._sender.address
        return [AddressClaimed(self._sender.address, self.name)]

    def _lose(self, address: int, name: int, now: float) -> list[Effect]:
        return [AddressLost(address, by=name), *self._claim(self._free(address + 1), now)]

    def _free(self, first: int) -> int | None:
        """The first address from this one up that nobody has, of those who answered the last scan or spoke since."""
        for step in range(ADDRESSES):
            address = (first + step) % ADDRESSES
            device = self._devices.at(address)
            if device is None or device.heard < self._scanned:
                return address
        return None

    def _met_our_name(self, address: int, now: float) -> list[Effect]:
        said = self._said.get((address, self.name))
        if said is not None and now < said + ECHO:
            return []
        if address <= self._sender.address:
            return self._move_on(now)
        if self._twin_due == NEVER:
            self._twin, self._twin_due = address, now + TWIN
        return self._say(now)

    def _move_on(self, now: float) -> list[Effect]:
        """Become the next of our kind."""
        self._twin, self._twin_due = NULL, NEVER
        return self.rename(with_instance(self.name, (self.name >> INSTANCE_AT) + 1), now)

    def _say(self, now: float) -> list[Effect]:
        self._owed = True
        return self._pay(now)

    def _pay(self, now: float) -> list[Effect]:
        """The claim that is owed, as soon as the pace allows it; the silence is counted from here."""
        if not self._owed or not self._pace.open(now):
            return []
        self._owed = False
        self._pace.count(now)
        address = self._sender.address
        self._said = {key: at for key, at in self._said.items() if now < at + ECHO} | {(address, self.name): now}
        if self.state is State.CLAIMING and self._due == NEVER:
            self._due = now + SILENCE
        return [Transmit(Frame(join(6, CLAIM, address), self.name.to_bytes(8, "little")))]
