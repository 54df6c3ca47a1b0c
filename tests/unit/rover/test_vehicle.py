"""The whole controller of a rover as one machine: what goes in, what comes out."""

import re
from typing import Annotated

import pytest

from timonel.core.alerts import AlertChanged
from timonel.core.effects import Effect, Refused, Rejected, Say, SecurityEvent, Transmit
from timonel.core.frame import Frame
from timonel.vehicles.rover.alerts import BATTERY
from timonel.vehicles.rover.conversions import Percent
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.drive import Permission, Stop
from timonel.vehicles.rover.frames import FRAMES, BatteryState, BmsStatus
from timonel.vehicles.rover.framing import DIALECTS
from timonel.vehicles.rover.protocol import Protocol
from timonel.vehicles.rover.settings import Port, RoverSettings
from timonel.vehicles.rover.vehicle import Rover

PORTS = [Port("Router", 1), Port("Jetson", 2), Port("Third", 3)]
PERMIT, FORBID = b"\x31", b"\xce"
FORWARD, REST = b"\x00\x9c", b"\x00\x00"
FULL, STANDSTILL = b"\x64" * 3, b"\x00" * 3
TELEMETRY = [frame.FRAME for frame in FRAMES if frame.TO is Party.OPERATOR]


class Gripper(RoverFrame, frame=160, to=Party.ROVER, sender="operator", rate=10):
    """A frame of an owner, for a module."""

    opening: Annotated[int | None, Percent()]


class Arm(RoverFrame, frame=161, to=Party.OPERATOR, sender="arm", rate=10, segmented=True):
    """Telemetry of an owner's module that takes two CAN frames."""

    j1: Annotated[int | None, Percent()]
    j2: Annotated[int | None, Percent()]
    j3: Annotated[int | None, Percent()]
    j4: Annotated[int | None, Percent()]
    j5: Annotated[int | None, Percent()]
    j6: Annotated[int | None, Percent()]
    j7: Annotated[int | None, Percent()]
    j8: Annotated[int | None, Percent()]
    j9: Annotated[int | None, Percent()]


class ArmPose(RoverFrame, frame=162, to=Party.ROVER, sender="operator", rate=10, segmented=True):
    """The same for the way out."""

    j1: Annotated[int | None, Percent()]
    j2: Annotated[int | None, Percent()]
    j3: Annotated[int | None, Percent()]
    j4: Annotated[int | None, Percent()]
    j5: Annotated[int | None, Percent()]
    j6: Annotated[int | None, Percent()]
    j7: Annotated[int | None, Percent()]
    j8: Annotated[int | None, Percent()]
    j9: Annotated[int | None, Percent()]


OWN = (Gripper, Arm, ArmPose)


def sent(effects: list[Effect]) -> list[tuple[int, bytes]]:
    return [(effect.frame.identifier, effect.frame.data) for effect in effects if isinstance(effect, Transmit)]


def said(effects: list[Effect]) -> list[tuple[bytes, str]]:
    return [(effect.line, effect.key) for effect in effects if isinstance(effect, Say)]


def refusals(effects: list[Effect]) -> list[Refused]:
    return [effect for effect in effects if isinstance(effect, Refused)]


class Yard:
    """A rover, and short ways to speak to it."""

    def __init__(self, **settings: object) -> None:
        self.rover = Rover(RoverSettings(**settings), PORTS, 0.0, Protocol(own=OWN))  # type: ignore[arg-type]
        self.write = DIALECTS[self.rover.settings.dialect].write
        self.now = 0.0
        self.first = self.until(0.0)

    def say(self, port: str, *frames: tuple[int, bytes]) -> list[Effect]:
        """Frames with a silence behind them, which proves the last."""
        effects = self.rover.receive_bytes(port, b"".join(self.write(*frame) for frame in frames), self.now)
        return effects + self.until(self.now + 0.006)

    def until(self, end: float) -> list[Effect]:
        effects: list[Effect] = []
        while self.rover.deadline <= end:
            self.now = max(self.now, self.rover.deadline)
            effects += self.rover.expire(self.now)
        self.now = end
        return effects

    def hold(self, port: str, stick: bytes, seconds: float) -> list[Effect]:
        """A stick, 50 times a second."""
        effects, end = [], self.now + seconds
        while self.now < end - 0.001:
            effects += self.say(port, (100, stick)) + self.until(self.now + 0.014)
        return effects

    def bus(self, *frames: tuple[int, bytes]) -> list[Effect]:
        return self.rover.receive_frames([Frame(*frame, extended=False) for frame in frames], self.now)

    def driven(self, port: str = "Router") -> "Yard":
        self.say(port, (100, REST), (101, PERMIT), (100, FORWARD))
        assert self.rover.drive.permitted
        return self

    @property
    def commander(self) -> int:
        return self.rover.helm.transfer.commander


# From the stations to the modules -------------------------------------------------------------------


def test_a_stick_becomes_set_points_for_both_sides_right_first():
    effects = Yard().driven().hold("Router", b"\x1e\xce", 0.1)
    assert [frame for frame in sent(effects) if frame[0] in (102, 103)][-2:] == [(102, b"\x14" * 3), (103, b"\x50" * 3)]


def test_set_points_are_frames_of_eleven_bits():
    effects = Yard().driven().hold("Router", FORWARD, 0.1)
    assert {effect.frame.extended for effect in effects if isinstance(effect, Transmit)} == {False}


def test_at_power_on_the_wheels_are_told_to_stand_and_the_drives_to_stop():
    assert sent(Yard().first) == [(102, STANDSTILL), (103, STANDSTILL), (101, FORBID)]


def test_permission_goes_to_the_modules_at_once_and_five_times_a_second():
    yard = Yard()
    assert sent(yard.say("Router", (100, REST), (101, PERMIT))).count((101, PERMIT)) == 1
    told = [frame for frame in sent(yard.hold("Router", REST, 1.0)) if frame[0] == 101]
    assert told == [(101, PERMIT)] * 5


def test_a_stop_of_any_station_goes_to_the_modules_before_the_zeros():
    yard = Yard().driven("Router")
    effects = yard.say("Third", (101, b"\x00"))
    assert sent(effects)[:3] == [(101, FORBID), (102, STANDSTILL), (103, STANDSTILL)]
    assert Permission(False, Stop.ORDERED.value) in effects
    assert yard.commander == 1


@pytest.mark.parametrize("byte", [0x00, 0x30, 0x32, 0xCE, 0xFF])
def test_anything_but_the_character_one_stops(byte: int):
    yard = Yard().driven()
    yard.say("Router", (101, bytes((byte,))))
    assert not yard.rover.drive.permitted


def test_the_age_of_a_stick_counts_from_its_last_byte_and_not_from_its_proof():
    yard = Yard().driven()
    yard.rover.receive_bytes("Router", b"#d\x00\x9c", 0.100)
    effects = yard.until(0.299)
    assert (102, FULL) in sent(effects)
    assert sent(yard.until(0.2999)) == []
    assert sent(yard.until(0.3001))[:2] == [(102, STANDSTILL), (103, STANDSTILL)]


def test_a_stick_that_the_next_frame_proves_is_as_old_as_its_bytes():
    yard = Yard().driven()
    yard.rover.receive_bytes("Router", b"#d\x00\x9c", 0.100)
    yard.rover.receive_bytes("Router", b"#", 0.104)
    yard.until(0.2999)
    assert sent(yard.until(0.3001))[:2] == [(102, STANDSTILL), (103, STANDSTILL)]


def test_a_station_cannot_send_what_is_not_for_the_rover():
    yard = Yard().driven()
    for identifier in (102, 103, 104, 116):
        data = b"\x31" * Protocol().declarations[identifier].size
        assert identifier not in dict(sent(yard.say("Router", (identifier, data))))
    assert yard.rover.framing()["Router"].counters.skipped > 0


def test_a_stick_out_of_range_is_refused_and_counted():
    yard = Yard().driven()
    assert refusals(yard.say("Router", (100, b"\x00\x9b"))) == [Refused("stick out of range", 1)]
    assert yard.rover.counters["stick out of range"] == 1


# Limits ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("identifier", "highest"), [(115, 20), (119, 20), (120, 200)])
def test_a_limit_within_its_range_goes_to_the_modules(identifier: int, highest: int):
    for steps in (1, highest):
        assert (identifier, bytes((steps,))) in sent(Yard().driven().say("Router", (identifier, bytes((steps,)))))
    for steps in (0, highest + 1, 255):
        yard = Yard().driven()
        effects = yard.say("Router", (identifier, bytes((steps,))))
        assert identifier not in dict(sent(effects))
        assert refusals(effects) == [Refused("limit out of range", 1)]
        assert yard.rover.counters["limit out of range"] == 1


def test_a_limit_is_the_commanders():
    yard = Yard().driven("Router")
    effects = yard.say("Jetson", (119, b"\x01"))
    assert refusals(effects) == [Refused("not in command", 2)]
    assert 119 not in dict(sent(effects))
    assert yard.rover.drive.speed_limit == 20


def test_the_mixer_heeds_the_speed_limit():
    yard = Yard().driven()
    yard.say("Router", (119, b"\x0a"))
    assert sent(yard.hold("Router", FORWARD, 0.1))[-2:] == [(102, b"\x32" * 3), (103, b"\x32" * 3)]


def test_the_last_limits_are_said_again_every_second():
    yard = Yard().driven()
    yard.say("Router", (119, b"\x0a"), (120, b"\x64"))
    yard.say("Router", (119, b"\x0b"))
    repeated = [frame for frame in sent(yard.until(3.5)) if frame[0] in (115, 119, 120)]
    assert repeated == [(119, b"\x0b"), (120, b"\x64")] * 3


# The ceiling ----------------------------------------------------------------------------------------


def test_no_frame_goes_to_a_module_more_often_than_fifty_times_a_second():
    yard = Yard().driven()
    effects = []
    for step in range(200):
        yard.now = 0.1 + step * 0.005
        effects += yard.rover.receive_bytes("Router", yard.write(160, b"\x01") + yard.write(100, FORWARD), yard.now)
    frames = [identifier for identifier, _ in sent(effects)]
    assert 50 <= frames.count(160) <= 52
    assert 50 <= frames.count(102) <= 52
    assert yard.rover.counters["frames beyond 50 Hz"] == 200 - frames.count(160)


def test_telemetry_that_comes_more_often_is_thinned():
    yard = Yard()
    lines = []
    for step in range(200):
        yard.now = step * 0.005
        lines += said(yard.bus((116, b"\x01")))
    assert 50 <= len(lines) <= 52


# From the modules to the stations -------------------------------------------------------------------


@pytest.mark.parametrize("dialect", ["strzyga", "strzyga-crc", "hal062"])
def test_telemetry_goes_to_all_links_framed_and_named_after_its_frame(dialect: str):
    yard = Yard(dialect=dialect)
    data = bytes(range(6))
    assert said(yard.bus((104, data))) == [(DIALECTS[dialect].write(104, data), "104")]


@pytest.mark.parametrize("identifier", [number for number in TELEMETRY if number != 111])
def test_every_frame_of_telemetry_is_passed_on(identifier: int):
    data = b"\x01" * Protocol().declarations[identifier].size
    assert said(Yard().bus((identifier, data))) == [(b"#%c%b" % (identifier, data), str(identifier))]


def test_the_twelve_bytes_of_111_are_passed_on_whole():
    data = bytes(range(12))
    assert said(Yard().rover.receive_message(111, data, 0.0)) == [(b"#o" + data, "111")]


def test_a_dialect_that_cannot_carry_them_leaves_them_out_and_they_are_counted():
    yard = Yard(dialect="hal062")
    assert yard.rover.receive_message(111, bytes(12), 0.0) == []
    assert yard.rover.counters["frames too long for the dialect"] == 1


@pytest.mark.parametrize(("identifier", "size"), [(104, 5), (104, 8), (111, 8), (111, 4), (118, 0), (118, 2)])
def test_a_frame_of_another_length_is_counted_and_not_passed_on(identifier: int, size: int):
    yard = Yard()
    assert yard.bus((identifier, bytes(size))) == [Rejected("wrong length", bytes(size), f"frame {identifier}")]
    assert yard.rover.counters["wrong length"] == 1


def test_a_frame_that_nobody_declared_is_counted():
    yard = Yard()
    assert yard.bus((130, b"\x01")) == [Rejected("undeclared frame", b"\x01", "frame 130")]
    extended = Frame(104, bytes(6))
    assert yard.rover.receive_frames([extended], 0.0) == [Rejected("undeclared frame", bytes(6), "frame 104")]
    assert yard.rover.counters["undeclared frame"] == 2


def test_another_controller_on_the_bus_is_told_once_and_counted():
    yard = Yard()
    assert yard.bus((102, FULL), (103, FULL)) == [
        SecurityEvent("somebody else sends WheelSpeedSetRight on the bus", "bus")
    ]
    assert yard.bus((101, PERMIT)) == []
    assert yard.rover.counters["frames of another controller"] == 3


def test_what_a_module_says_of_itself_becomes_an_alert():
    yard = Yard()
    data = yard.rover.protocol.encode(BmsStatus(status=BatteryState.OVER_CURRENT))[1]
    effects = yard.bus((118, data))
    assert [type(effect) for effect in effects] == [AlertChanged, Say]
    assert yard.rover.helm.alerts.active(BATTERY)


# Frames of its owner --------------------------------------------------------------------------------


def test_an_owners_frame_goes_to_its_module_from_the_commander_alone():
    yard = Yard().driven("Router")
    assert (160, b"\x07") in sent(yard.say("Router", (160, b"\x07")))
    effects = yard.say("Jetson", (160, b"\x08"))
    assert 160 not in dict(sent(effects))
    assert refusals(effects) == [Refused("not in command", 2)]


def test_a_frame_of_more_than_eight_bytes_crosses_the_bus_in_two():
    yard = Yard().driven()
    effects = yard.say("Router", (162, bytes(range(9))))
    assert [frame for frame in sent(effects) if frame[0] == 162] == [(162, bytes(range(8))), (162, b"\x08")]
    whole = [*yard.bus((161, bytes(range(8)))), *yard.bus((161, b"\x08"))]
    assert said(whole) == [(b"#\xa1" + bytes(range(9)), "161")]


def test_a_half_without_its_partner_is_dropped_and_counted():
    yard = Yard()
    yard.bus((161, bytes(8)))
    yard.now = 0.03
    assert yard.bus((161, b"\x08")) == []
    assert yard.rover.counters["halves without their partner"] == 2


# Ports ----------------------------------------------------------------------------------------------


def test_an_unplugged_commander_stops_at_once():
    yard = Yard().driven("Jetson")
    effects = yard.rover.port_changed("Jetson", False, yard.now)
    assert sent(effects)[:3] == [(101, FORBID), (102, STANDSTILL), (103, STANDSTILL)]
    assert Permission(False, "the link of the commander was unplugged") in effects


@pytest.mark.parametrize(("port", "connected"), [("Router", False), ("Jetson", True), ("Listener", False)])
def test_other_ports_that_come_and_go_stop_nothing(port: str, connected: bool):
    yard = Yard().driven("Jetson")
    assert sent(yard.rover.port_changed(port, connected, yard.now)) == []
    assert yard.rover.drive.permitted


def test_half_a_frame_of_an_unplugged_port_is_not_finished_by_the_next_one():
    yard = Yard().driven()
    yard.rover.receive_bytes("Third", b"#e", yard.now)
    skipped = yard.rover.framing()["Third"].counters
    yard.rover.port_changed("Third", False, yard.now)
    yard.rover.receive_bytes("Third", b"\x00#", yard.now)
    assert yard.rover.drive.permitted
    assert yard.rover.framing()["Third"].counters is skipped, "the quality of a link outlives its plug"


# Time -----------------------------------------------------------------------------------------------


def test_what_is_overdue_happens_before_what_comes_in():
    yard = Yard().driven()
    effects = yard.rover.receive_bytes("Router", b"#d\x00\x9c#", 1.0)
    assert Permission(False, "the commander fell silent") in effects
    assert (102, FULL) not in sent(effects)


def test_a_late_frame_of_the_bus_finds_the_drives_stopped():
    yard = Yard().driven()
    yard.now = 1.0
    assert Permission(False, "the commander fell silent") in yard.bus((116, b"\x01"))


# The far end of a link to a controller --------------------------------------------------------------


def operator() -> Yard:
    yard = Yard(role="operator")
    yard.bus((116, b"\x02"))
    return yard


def test_an_operators_end_says_stick_and_permission_and_never_a_set_point():
    yard = operator()
    effects = yard.say("Router", (100, REST), (101, PERMIT))
    for _ in range(5):
        yard.bus((116, b"\x01"))
        effects += yard.hold("Router", FORWARD, 0.4)
    assert {identifier for identifier, _ in sent(effects)} == {100, 101}
    assert (100, FORWARD) in sent(effects)


def test_it_says_a_permission_three_times_and_a_stop_as_long_as_its_station_is_in_command():
    yard = operator()
    effects = yard.say("Router", (100, REST), (101, PERMIT))
    for _ in range(5):
        yard.bus((116, b"\x01"))
        effects += yard.hold("Router", REST, 0.4)
    assert sent(effects).count((101, PERMIT)) == 3
    effects = yard.say("Router", (101, FORBID))
    for _ in range(5):
        effects += yard.hold("Router", REST, 0.4)
    assert sent(effects).count((101, FORBID)) >= 9


def test_without_a_station_in_command_it_is_silent_so_that_others_may_drive_at_the_far_end():
    yard = operator()
    assert sent(yard.until(yard.now + 5.0)) == []
    yard.say("Router", (100, REST), (101, PERMIT))
    assert (101, FORBID) in sent(yard.until(yard.now + 3.0)), "a last stop"
    assert sent(yard.until(yard.now + 5.0)) == []


def test_it_stops_when_the_rover_falls_silent_for_half_a_second():
    yard = operator().driven()
    yard.hold("Router", FORWARD, 0.48)
    assert yard.rover.drive.permitted
    effects = yard.hold("Router", FORWARD, 0.06)
    assert Permission(False, "the rover fell silent") in effects
    assert sent(effects)[-1] == (100, REST)


def test_a_controller_does_not_stop_when_its_modules_are_silent():
    yard = Yard().driven()
    yard.hold("Router", FORWARD, 1.0)
    assert yard.rover.drive.permitted


def test_its_owners_long_frames_go_out_whole():
    yard = operator().driven()
    assert (162, bytes(range(9))) in sent(yard.say("Router", (162, bytes(range(9)))))


def test_its_limits_go_out_too():
    assert (119, b"\x05") in sent(operator().driven().say("Router", (119, b"\x05")))


def test_every_reason_of_a_refusal_is_counted_by_its_words():
    yard = Yard().driven()
    yard.say("Router", (101, PERMIT))
    assert yard.rover.counters == {"stick not at rest": 1}
    assert all(re.fullmatch("[a-z0-9 ]+", reason) for reason in yard.rover.counters)
