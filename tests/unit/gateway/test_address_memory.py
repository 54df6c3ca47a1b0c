"""What the node remembers over a restart."""

import asyncio
import logging
import os
import time
from pathlib import Path

import msgspec
import pytest

from timonel.core.effects import Effect
from timonel.gateway.address_memory import Memory, remember, remembered
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import Configuration
from timonel.nmea2000.claim import AddressClaimed, NoAddress, with_instance
from timonel.nmea2000.node import Described, NodeSettings
from timonel.vehicles.boat.settings import BoatSettings
from timonel.vehicles.rover.settings import RoverSettings

NODE = NodeSettings(unique_number=1234)
CONFIGURED = Configuration("boat.toml", BoatSettings(node=NODE), "loop://memory")


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path / "state"))
    return tmp_path / "state" / f"node-{NODE.name:016x}.json"


def happen(*effects: Effect) -> None:
    """A run of the gateway in which these things happen."""

    async def run() -> None:
        gateway = assemble(CONFIGURED)
        remember(gateway, CONFIGURED)
        (memory,) = gateway.observers
        memory.frames_received([], 0.0)
        memory.port("bus", True, 0.0)
        for effect in effects:
            memory.effect(effect, 0.0)
        await asyncio.get_running_loop().shutdown_default_executor()

    asyncio.run(run())


def test_the_first_time_all_is_as_configured() -> None:
    assert remembered(CONFIGURED) == CONFIGURED


def test_the_address_and_the_instances_that_were_claimed_come_first_the_next_time() -> None:
    name = with_instance(NODE.name, 2) | 3 << 56
    happen(AddressClaimed(40, NODE.name), AddressClaimed(41, name), NoAddress())
    vehicle = remembered(CONFIGURED).vehicle
    assert isinstance(vehicle, BoatSettings)
    assert vehicle == BoatSettings(address=41, node=msgspec.structs.replace(NODE, device_instance=2, system_instance=3))
    assert vehicle.node is not None
    assert vehicle.node.name == name


def test_of_two_addresses_claimed_at_once_the_last_is_kept_however_slow_the_card_is(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    replace, pauses = os.replace, [0.1, 0.0]

    def slow(new: Path, path: Path) -> None:
        time.sleep(pauses.pop(0))
        replace(new, path)

    monkeypatch.setattr("timonel.gateway.address_memory.os.replace", slow)
    happen(AddressClaimed(40, NODE.name), AddressClaimed(41, NODE.name))
    vehicle = remembered(CONFIGURED).vehicle
    assert isinstance(vehicle, BoatSettings)
    assert vehicle.address == 41
    assert caplog.messages == []


def test_what_an_installer_wrote_is_kept() -> None:
    happen(Described("port", "locker"))
    vehicle = remembered(CONFIGURED).vehicle
    assert vehicle == BoatSettings(node=msgspec.structs.replace(NODE, installation1="port", installation2="locker"))


@pytest.mark.parametrize("text", [b"{", b'{"address": 300}', b'{"installation1": 7}', b"\xff"])
def test_a_file_that_makes_no_sense_is_as_good_as_none(state: Path, text: bytes) -> None:
    state.parent.mkdir()
    state.write_bytes(text)
    assert remembered(CONFIGURED) == CONFIGURED


def test_what_is_as_it_was_is_not_written_again(state: Path) -> None:
    happen(AddressClaimed(40, NODE.name))
    state.unlink()

    async def again() -> None:
        memory = Memory(state)
        memory._kept = msgspec.structs.replace(memory._kept, address=40, device_instance=0, system_instance=0)
        memory.effect(AddressClaimed(40, NODE.name), 0.0)
        await asyncio.get_running_loop().shutdown_default_executor()

    asyncio.run(again())
    assert not state.exists()


def test_a_place_that_cannot_be_written_to_is_said_and_nothing_else(
    state: Path, caplog: pytest.LogCaptureFixture
) -> None:
    state.parent.write_text("not a directory")
    with caplog.at_level(logging.WARNING):
        happen(AddressClaimed(40, NODE.name))
    assert "looked for anew after a restart" in caplog.text


@pytest.mark.parametrize("settings", [BoatSettings(), RoverSettings()])
def test_a_vehicle_without_a_node_remembers_nothing(settings: BoatSettings | RoverSettings) -> None:
    configuration = Configuration("a.toml", settings, "loop://memory")
    assert remembered(configuration) is configuration

    async def run() -> None:
        gateway = assemble(configuration)
        remember(gateway, configuration)
        assert gateway.observers == []

    asyncio.run(run())
