import logging

import pytest

from timonel.core.alerts import Alert, AlertChanged, AlertKind, Priority
from timonel.core.command import Denied, Overridden, Requested, Transferred
from timonel.core.effects import Event, Refused, Rejected, SecurityEvent
from timonel.gateway.health import KINDS_MAX, LINES, LINES_WINDOW, Health
from timonel.vehicles.boat.alerts import BACKBONE_SILENT, PILOT_NOT_FOLLOWING
from timonel.vehicles.boat.foreign_alerts import FIRST
from timonel.vehicles.boat.pilot import Mode, PilotChanged, Steer
from timonel.vehicles.boat.pilots.driver import GaveUp, Progressed

SILENT = Alert(BACKBONE_SILENT, "nothing heard for 3 s", since=0.0)
DEAF = Alert(PILOT_NOT_FOLLOWING, "engage not followed for 2 s", since=0.0)
GARBAGE = Rejected("wrong check sum", b"$PARP\xff*00", "Bridge")


@pytest.fixture
def log(caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    caplog.set_level(logging.DEBUG)
    return caplog


@pytest.mark.parametrize(
    ("event", "level", "text"),
    [
        (Transferred(0, 2), "INFO", "command passes from nobody to station 2"),
        (Requested(3), "INFO", "station 3 requests command"),
        (Denied(3), "INFO", "the request of station 3 is denied"),
        (Overridden((2, 3)), "INFO", "the bridge insists: no more requests of station 2, station 3"),
        (Refused("not in command", 2), "INFO", "station 2 refused: not in command"),
        (SecurityEvent("another id", "Bridge", 3), "WARNING", "Bridge: another id (station 3 named)"),
        (GARBAGE, "INFO", r"Bridge: rejected, wrong check sum: $PARP\xff*00"),
        (Rejected("too long"), "INFO", "a peer: rejected, too long: "),
        (PilotChanged(Mode.HEADING_HOLD, 75), "INFO", "pilot: HEADING_HOLD 007.5"),
        (PilotChanged(Mode.UNKNOWN, None), "INFO", "pilot: unknown mode"),
        (Steer(1825), "DEBUG", "to the pilot: hold 182.5"),
        (Steer(None), "DEBUG", "to the pilot: let go"),
        (Progressed(), "DEBUG", "the pilot followed a step"),
        (GaveUp("command has passed"), "INFO", "the pilot's course is given up: command has passed"),
        (AlertChanged(SILENT), "ERROR", "alarm stands: backbone silent: nothing heard for 3 s"),
        (AlertChanged(DEAF), "WARNING", "warning stands: pilot not following: engage not followed for 2 s"),
    ],
)
def test_an_event_is_logged_as_a_sentence(log: pytest.LogCaptureFixture, event: Event, level: str, text: str) -> None:
    Health().event(event, now=0.0)
    assert [(record.levelname, record.getMessage()) for record in log.records] == [(level, text)]


@pytest.mark.parametrize(
    ("alert", "text"),
    [
        (Alert(BACKBONE_SILENT, "x", 0.0, acknowledged=True), "alarm acknowledged: backbone silent: x"),
        (Alert(BACKBONE_SILENT, "x", 0.0, silenced_until=30.0), "alarm silenced: backbone silent: x"),
        (Alert(BACKBONE_SILENT, "x", 0.0, active=False), "alarm is over: backbone silent: x"),
    ],
)
def test_an_alert_is_logged_with_its_state(log: pytest.LogCaptureFixture, alert: Alert, text: str) -> None:
    Health().event(AlertChanged(alert), now=0.0)
    assert log.messages == [text]


def test_an_event_has_its_values_for_json(log: pytest.LogCaptureFixture) -> None:
    Health().event(GARBAGE, now=0.0)
    assert log.records[0].__dict__["fields"] == {
        "event": "Rejected",
        "reason": "wrong check sum",
        "data": r"$PARP\xff*00",
        "source": "Bridge",
    }


def test_a_peer_that_repeats_itself_is_counted_but_not_always_logged(log: pytest.LogCaptureFixture) -> None:
    health = Health()
    for _ in range(LINES + 5):
        health.event(GARBAGE, now=0.0)
    assert len(log.messages) == LINES
    assert health.counts["rejected Bridge: wrong check sum"] == LINES + 5
    health.event(GARBAGE, now=LINES_WINDOW)
    assert log.messages[-1].endswith("(and 5 more before)")
    health.event(GARBAGE, now=LINES_WINDOW)
    assert not log.messages[-1].endswith("before)")


def test_one_peers_noise_does_not_hide_anothers(log: pytest.LogCaptureFixture) -> None:
    health = Health()
    for _ in range(LINES + 1):
        health.event(GARBAGE, now=0.0)
    health.event(Rejected("wrong check sum", b"", "Cockpit"), now=0.0)
    assert log.messages[-1].startswith("Cockpit")


def test_every_transfer_of_command_is_logged(log: pytest.LogCaptureFixture) -> None:
    health = Health()
    for _ in range(LINES + 5):
        health.event(Transferred(1, 2), now=0.0)
    assert len(log.messages) == LINES + 5


def test_an_inventive_peer_does_not_fill_the_memory() -> None:
    health = Health()
    for number in range(KINDS_MAX + 50):
        health.event(Rejected(f"reason {number}"), now=0.0)
    assert len(health.counts) == KINDS_MAX + 1
    assert health.counts["other"] == 50


def test_a_report_has_all_counters_that_are_not_zero(log: pytest.LogCaptureFixture) -> None:
    health = Health()
    health.watch("Bridge", lambda: {"bytes_in": 12, "dropped": 0})
    health.watch("Cockpit", lambda: {"bytes_in": 0})
    health.event(Refused("not in command", 2), now=0.0)
    health.report()
    assert log.messages[-1] == "health: Bridge: bytes in 12; events: refused 2: not in command 1"


def test_a_link_that_comes_and_goes_is_logged(log: pytest.LogCaptureFixture) -> None:
    health = Health()
    health.link("Bridge", True, "")
    health.link("Bridge", False, "unplugged")
    assert [(record.levelname, record.getMessage()) for record in log.records] == [
        ("INFO", "Bridge: connected"),
        ("WARNING", "Bridge: not connected (unplugged)"),
    ]


def test_other_devices_alerts_cannot_flood_the_log_and_ours_are_always_in_it(log: pytest.LogCaptureFixture) -> None:
    health = Health()
    theirs = Alert(AlertKind(FIRST, "bilge", Priority.ALARM), "", since=0.0)
    for _ in range(100):
        health.event(AlertChanged(theirs), now=0.0)
        health.event(AlertChanged(SILENT), now=0.0)
    assert sum("bilge" in message for message in log.messages) == LINES
    assert sum("backbone" in message for message in log.messages) == 100
    assert health.counts["alert of another device"] == 100
