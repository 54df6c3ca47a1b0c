"""A gateway that says what a test wants to see: the socket is played, the page is the real one."""

import json
from math import radians
from pathlib import Path
from typing import Any

from playwright.sync_api import Page

Topics = dict[str, Any]
CLOCK = 100.0
PLAYED = Path(__file__).with_name("played_gateway.js").read_text()
STATIONS = {1: "Bridge", 2: "Cockpit", 3: "Flybridge", 4: "Reserve"}


def measured(value: float | None, quality: str = "fresh", at: float = CLOCK) -> Topics:
    return {"value": value, "at": at, "quality": quality}


def direction(degrees: float, quality: str = "fresh") -> Topics:
    return measured(radians(degrees), quality) | {"reference": "true"}


def wind(speed: float, degrees: float) -> Topics:
    return {"speed": speed, "angle": radians(degrees), "at": CLOCK, "quality": "fresh"}


def boat() -> Topics:
    """A boat on 055 that station 2 commands."""
    stations = [{"id": number, "name": name, "connected": True, "web": 0} for number, name in STATIONS.items()]
    return {
        "command": {
            "commander": 2, "commander_name": "Cockpit", "stations": stations, "queue": [], "deadline": None,
            "policy": "transfer",
        },
        "pilot": {"mode": "HEADING_HOLD", "setpoint": radians(55.5), "reference": "true", "pending": False},
        "heading": direction(44.8), "cog": direction(49.0), "sog": measured(3.2), "stw": measured(3.05),
        "rudder": measured(radians(6.2)), "rate_of_turn": measured(radians(0.7)), "depth": measured(23.4),
        "wind_apparent": wind(7.4, 42), "wind_true": wind(6.1, 68), "water_temperature": measured(292.2),
        "position": {"latitude": 39.5512, "longitude": 2.6311, "at": CLOCK, "quality": "fresh"},
        "utc": measured(1795344399.0), "variation": measured(radians(1.8)),
        "devices": [
            device(35, "", "timonel", "PC Gateway", ours=True),
            device(204, "Raymarine", "EV-1 Course Computer", "Autopilot", software="2.21", serial="0451234"),
            device(None, "Garmin", None, "Display"),
        ],
        "links": [
            {"name": "bus", "kind": "bus", "connected": True, "reason": "", "at": 1.0},
            {"name": "Bridge", "kind": "in", "connected": False, "reason": "no program has it open", "at": 1.0},
        ],
        "alerts": [], "events": [],
    }  # fmt: skip


def device(
    address: int | None,
    maker: str,
    model: str | None,
    function: str,
    *,
    software: str | None = None,
    serial: str | None = None,
    ours: bool = False,
) -> Topics:
    return {
        "address": address, "name": "C0328200FCE004D2", "maker": maker, "model": model, "software": software,
        "serial": serial, "function": function, "instance": 0, "installation": None, "since": 1.0, "ours": ours,
    }  # fmt: skip


def alert(
    priority: str, *, acknowledged: bool = False, silenced_until: float | None = None, announced: int = 0
) -> Topics:
    return {
        "id": 101, "name": "backbone silent", "text": "nothing heard from the backbone for 3 s", "priority": priority,
        "active": True, "acknowledged": acknowledged, "silenced_until": silenced_until, "since": CLOCK - 5,
        "announced": announced,
    }  # fmt: skip


class PlayedGateway:
    """Plays the gateway of a page that is not loaded yet. `station` is what the page is."""

    def __init__(self, page: Page, topics: Topics, station: int | None = 2) -> None:
        self.topics = topics
        self._page = page
        you = {"role": "admin", "station": station, "may_choose": list(STATIONS)}
        opening = {"type": "snapshot", "sequence": 1, "clock": CLOCK, "vehicle": "boat", "name": "played", "you": you}
        page.add_init_script(PLAYED.replace("OPENING", json.dumps(opening | {"topics": topics})))

    def change(self, clock: float | None = None, since: int | None = None, **topics: Any) -> None:
        """Topics change; `since` another number than the last makes a gap."""
        self.topics.update(topics)
        self._page.evaluate("([topics, clock, since]) => played.change(topics, clock, since)", [topics, clock, since])
        self._page.evaluate("new Promise(done => requestAnimationFrame(() => setTimeout(done)))")

    def answer(self, *replies: tuple[str, str]) -> None:
        """Every message with an id is answered so: outcome and reason."""
        self._page.evaluate("replies => { played.replies = replies }", replies)

    def fall_silent(self) -> None:
        """It says nothing any more, to new sockets neither."""
        self._page.evaluate("played.mute = true")

    @property
    def heard(self) -> list[Topics]:
        """What the page said."""
        return list(self._page.evaluate("played.heard"))

    def orders(self) -> list[str]:
        """The words of the `$PARP` family that it heard."""
        return [said["verb"] for said in self.heard if said["type"] == "command"]
