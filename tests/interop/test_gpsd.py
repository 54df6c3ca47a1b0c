"""A real gpsd reads the simulated boat: over TCP, and over a pseudo-terminal as if it were a receiver's port."""

import asyncio
import json
import re
import shutil
import socket
import subprocess
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from tests.program import Program, free_port, until

HERE = "127.0.0.1"
KNOT = 1852 / 3600
MODE_3D = 3
SHOWN = {"time", "lat", "lon", "speed", "track", "depth"}
ENOUGH = 5  # reports of each kind

pytestmark = pytest.mark.timeout(90)


class Heard:
    """What gpspipe showed, and what the boat's stations heard in that time.

    `fixes` are those with a course: between two of them gpsd also tells a speed that it worked out from positions.
    """

    def __init__(self, reports: list[dict[str, Any]], sentences: list[str], log: list[dict[str, Any]]) -> None:
        self.fixes = [report for report in reports if report.keys() >= SHOWN - {"depth"} and report["mode"] == MODE_3D]
        self.attitudes = [report for report in reports if report["class"] == "ATT"]
        self.sentences = sentences
        self.log = log

    def fields(self, formatter: str) -> Iterator[list[str]]:
        for sentence in self.sentences:
            if sentence[3:6] == formatter:
                yield sentence.partition("*")[0].split(",")

    def said(self, formatter: str, field: int) -> set[float]:
        """All values that this field had."""
        return {float(fields[field]) for fields in self.fields(formatter) if fields[field]}

    def positions(self) -> set[tuple[float, float]]:
        """Of RMC, GGA and GLL, in degrees, as gpsd prints them."""
        places = {"RMC": 3, "GGA": 2, "GLL": 1}
        return {
            (angle(*fields[first : first + 2]), angle(*fields[first + 2 : first + 4]))
            for formatter, first in places.items()
            for fields in self.fields(formatter)
            if fields[first]
        }


def angle(text: str, hemisphere: str) -> float:
    """ddmm.mmmmmm as degrees."""
    match = re.fullmatch(r"(\d+)(\d\d\.\d+)", text)
    assert match is not None
    return (int(match[1]) + float(match[2]) / 60) * (-1 if hemisphere in "SW" else 1)


def tool(name: str) -> str:
    path = shutil.which(name, path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")
    if path is None:
        pytest.fail(f"{name} is missing: apt-get install gpsd gpsd-clients")
    return path


async def listen(directory: Path, source: Callable[[int], str]) -> Heard:
    """Let gpsd read the demo at `source` (a function of its TCP port) until there is enough to look at."""
    port, control = free_port(), free_port()
    async with Program(
        directory, "demo", "--no-view", "--no-web", "--port", str(port), "--directory", str(directory)
    ) as demo:
        await demo.running()
        log = (directory / "gpsd.log").open("wb")
        gpsd = subprocess.Popen([tool("gpsd"), "-N", "-n", "-S", str(control), source(port)], stderr=log)
        try:
            reports = await pipe(control, directory / "reports.jsonl")
        finally:
            gpsd.kill()
            gpsd.wait()
            log.close()
        return Heard(reports, demo.output_path.read_text().splitlines(), demo.log())


async def pipe(control: int, path: Path) -> list[dict[str, Any]]:
    def reports() -> list[dict[str, Any]]:
        whole = path.read_text().rpartition("\n")[0]
        return [json.loads(line) for line in whole.splitlines()]

    def enough() -> bool:
        fixes = [report for report in reports() if report.keys() >= SHOWN]
        attitudes = [report for report in reports() if report["class"] == "ATT"]
        return min(len(fixes), len(attitudes)) >= ENOUGH

    await until(lambda: listening(control), "gpsd listens")
    with path.open("wb") as file:
        gpspipe = subprocess.Popen([tool("gpspipe"), "-w", f"{HERE}:{control}"], stdout=file)
    try:
        await until(enough, f"{SHOWN} and heading from gpspipe", 60.0)
    finally:
        gpspipe.kill()
        gpspipe.wait()
    return reports()


def listening(port: int) -> bool:
    with socket.socket() as stream:
        return stream.connect_ex((HERE, port)) == 0


@pytest.fixture(scope="module", params=["tcp", "pseudo-terminal"])
def heard(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Heard:
    directory = tmp_path_factory.mktemp("gpsd")
    sources: dict[str, Callable[[int], str]] = {
        "tcp": lambda port: f"tcp://{HERE}:{port}",
        "pseudo-terminal": lambda port: str(directory / "bridge"),
    }
    return asyncio.run(listen(directory, sources[request.param]))


def test_gpsd_shows_the_position_of_the_boat(heard: Heard) -> None:
    said = heard.positions()
    for fix in heard.fixes:
        near = [p for p in said if abs(p[0] - fix["lat"]) < 1e-8 and abs(p[1] - fix["lon"]) < 1e-8]
        assert near, (fix["lat"], fix["lon"])


def test_gpsd_shows_its_speed_and_its_course(heard: Heard) -> None:
    speeds = heard.said("RMC", 7) | heard.said("VTG", 5)
    courses = heard.said("RMC", 8) | heard.said("VTG", 1)
    for fix in heard.fixes:
        assert any(abs(speed * KNOT - fix["speed"]) < 1e-3 for speed in speeds), fix["speed"]
        assert any(abs(course - fix["track"]) < 1e-3 for course in courses), fix["track"]


def test_gpsd_shows_its_depth(heard: Heard) -> None:
    depths = heard.said("DBT", 3)
    assert {fix["depth"] for fix in heard.fixes if "depth" in fix} <= depths


def test_gpsd_shows_its_true_heading(heard: Heard) -> None:
    assert {attitude["heading"] for attitude in heard.attitudes} <= heard.said("HDT", 1)


def test_gpsd_shows_the_time_of_the_bus(heard: Heard) -> None:
    said = {(fields[9], float(fields[1])) for fields in heard.fields("RMC") if fields[1]}
    for fix in heard.fixes:
        moment = datetime.fromisoformat(fix["time"])
        assert (f"{moment:%d%m%y}", float(f"{moment:%H%M%S.%f}")) in said


def test_what_gpsd_says_to_a_station_s_port_commands_nothing(heard: Heard) -> None:
    assert not [record for record in heard.log if record.get("event") in ("Transferred", "PilotChanged", "fault")]
