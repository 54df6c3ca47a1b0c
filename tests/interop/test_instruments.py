"""Instruments on TCP wires, the whole program, and another's decoder at the bus: the PyPI package `nmea2000`."""

import asyncio
from math import radians
from pathlib import Path

import pytest
from nmea2000 import backend

from tests.program import Program, free_port, until
from timonel.nmea0183.checksum import seal
from timonel.nmea2000.identifier import split

HERE = "127.0.0.1"
TICK = 0.1  # s

pytestmark = pytest.mark.timeout(90)


class Lines:
    """What comes out of a port."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    async def take(self, port: int) -> None:
        reader, writer = await asyncio.open_connection(HERE, port)
        while line := await reader.readline():
            self.lines.append(line.decode().strip())
        writer.close()

    def values(self, pgn: int, field: str) -> list[float]:
        """A field of a single-frame PGN, as another decoder reads the raw frames."""
        found = []
        for line in self.lines:
            _, _, identifier, *data = line.split()
            target = split(int(identifier, 16))
            if target.pgn == pgn:
                message = backend.decode(pgn, bytes.fromhex("".join(data)), target.source, units="si")
                found += [told.value for told in message.fields if told.id == field]
        return found


def configuration(ports: dict[str, int]) -> str:
    return f"""
[vehicle]
kind = "boat"
backbone = "optional"
[bus]
url = "loop://instruments"
node = false
[[input]]
name = "Compass"
url = "tcp-listen://{HERE}:{ports["compass"]}"
[[input]]
name = "Spare"
url = "tcp-listen://{HERE}:{ports["spare"]}"
[[output]]
url = "tcp-listen://{HERE}:{ports["sentences"]}"
[[output]]
name = "raw"
url = "tcp-listen://{HERE}:{ports["raw"]}"
format = "ydraw"
[sources]
heading = ["Compass", "Spare"]
[[correction]]
source = "Spare"
heading_deg = 0.5
"""


def test_the_bus_has_the_compass_and_when_that_is_silent_the_spare_one(tmp_path: Path) -> None:
    asyncio.run(silenced(tmp_path))


async def silenced(tmp_path: Path) -> None:
    ports = {name: free_port() for name in ("compass", "spare", "sentences", "raw")}
    file = tmp_path / "boat.toml"
    file.write_text(configuration(ports))
    async with Program(tmp_path, "run", str(file)) as program:
        await program.running()
        bus, outputs = Lines(), Lines()
        listening = [
            asyncio.create_task(lines.take(ports[name])) for lines, name in ((bus, "raw"), (outputs, "sentences"))
        ]
        _, compass = await asyncio.open_connection(HERE, ports["compass"])
        _, spare = await asyncio.open_connection(HERE, ports["spare"])

        async def speak(until_said: str, *, by_compass: bool) -> None:
            for _ in range(150):
                if by_compass:
                    compass.write(seal("HEHDT,90.0,T"))
                spare.write(seal("HEHDT,94.5,T") + seal("SDDPT,4.2,0.5"))
                await asyncio.sleep(TICK)
                if any(until_said in line for line in outputs.lines[-12:]) and bus.lines:
                    return
            raise AssertionError(outputs.lines[-12:])

        await speak("HDT,90.0", by_compass=True)
        await speak("HDT,95.0", by_compass=False)
        await until(lambda: radians(95) == pytest.approx(bus.values(127250, "heading")[-1], abs=1e-4), "the spare one")
        told = bus.values(127250, "heading")
        assert told[0] == pytest.approx(radians(90), abs=1e-4)
        assert set(bus.values(128267, "depth")) <= {4.2}
        changes = [record["text"] for record in program.log() if record.get("event") == "SourceChanged"]
        assert "true heading: from Spare, no longer Compass" in changes
        compass.close()
        spare.close()
        await program.stop()
        await asyncio.gather(*listening)
