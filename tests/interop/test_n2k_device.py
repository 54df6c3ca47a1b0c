"""PyPI `nmea2000`'s device on one bus with our node, over a YD RAW server of ours: two devices of different makers."""

import asyncio
import json
import subprocess
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import msgspec
import pytest
from nmea2000.device import N2KDevice
from nmea2000.input_formats import N2KFormat

from tests.program import free_port, until
from tests.unit.cli.programs import timonel
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import parse
from timonel.gateway.devices import DeviceShown
from timonel.gateway.gateway import Gateway
from timonel.links.urls import bus_link
from timonel.nmea2000.devices import Device, Devices
from timonel.nmea2000.messages.network import IsoRequest
from timonel.nmea2000.node import Node, NodeSettings
from timonel.nmea2000.sender import Outgoing, Sender, outgoing
from timonel.vehicles.boat.vehicle import Boat

HERE = "127.0.0.1"
ADDRESS = 35
THEIRS = 50
THIRD = 99
NODE = Path(__file__).parent / "node"

pytestmark = pytest.mark.timeout(60)


@asynccontextmanager
async def a_gateway(url: str, port: int, device_class: int = 25) -> AsyncIterator[tuple[Gateway, Node]]:
    """Our node on a bus, and a server by which others come on it."""
    text = f"""
        [vehicle]
        kind = "boat"
        [bus]
        url = "{url}"
        address = {ADDRESS}
        unique_number = 1234
        class = {device_class}
        installation1 = "chart table"
        [[output]]
        url = "tcp-listen://{HERE}:{port}"
        format = "ydraw"
        transmit = true
        """
    gateway = assemble(parse(text))
    assert isinstance(gateway.vehicle, Boat)
    await gateway.open()
    try:
        yield gateway, gateway.vehicle.node
    finally:
        await gateway.close()


@asynccontextmanager
async def a_device(make: Callable[..., N2KDevice], directory: Path) -> AsyncIterator[N2KDevice]:
    device = make(
        client_options={"seed_network_map": False},
        preferred_address=THEIRS,
        unique_number=7,
        model_id="the other one",
        installation_description1="mast",
        persistence_path=directory / "device.json",
    )
    await device.start()
    try:
        yield device
    finally:
        await device.close()


def over_text(port: int) -> Callable[..., N2KDevice]:
    return partial(N2KDevice.for_text_gateway, HERE, port, N2KFormat.CAN_FRAME_ASCII)


async def say(url: str, *messages: Outgoing) -> None:
    """A third device, which has no more than an address, says something to all."""
    end = bus_link(url)
    await end.open(lambda _: None, lambda *_: None)
    sender = Sender(THIRD)
    for message in messages:
        end.send(sender.frames(message))
    await asyncio.sleep(0.05)
    await end.close()


def known(gateway: Gateway, device: N2KDevice) -> Device:
    assert isinstance(gateway.vehicle, Boat)
    found = gateway.vehicle.devices.by_name(device.own_name)
    assert found is not None
    return found


async def they_know_each_other(gateway: Gateway, device: N2KDevice, url: str) -> None:
    """Both have an address, and each learns what the other is."""
    assert isinstance(gateway.vehicle, Boat)
    node = gateway.vehicle.node
    await until(lambda: device.ready and node.operating, "both have an address")
    assert (node.address, device.address) == (ADDRESS, THEIRS)
    await until(lambda: known(gateway, device).product and known(gateway, device).configuration, "we know it")
    theirs = known(gateway, device)
    assert theirs.product is not None
    assert theirs.configuration is not None
    assert (theirs.address, theirs.product.model_id) == (THEIRS, "the other one")
    assert theirs.configuration.installation_description1 == "mast"
    await say(url, *(outgoing(IsoRequest(pgn=pgn), ADDRESS) for pgn in (126996, 126998)))
    await until(lambda: device.devices[ADDRESS].configuration_information, "it knows us")
    ours = device.devices[ADDRESS]
    assert ours.product_information is not None
    assert ours.configuration_information is not None
    assert ours.product_information.get_field_str_value_by_id("modelId") == "timonel"
    assert ours.configuration_information.get_field_str_value_by_id("installationDescription1") == "chart table"


async def they_contend(node: Node, device: N2KDevice, url: str) -> None:
    """Both know better than to take an address that is taken, so our node is commanded to theirs (65240 by BAM)."""
    await until(lambda: device.ready and node.operating, "both have an address")
    commanded = node.name.to_bytes(8, "little") + bytes((THEIRS,))
    await say(
        url,
        Outgoing(60416, bytes((32, 9, 0, 2, 255)) + (65240).to_bytes(3, "little")),
        Outgoing(60160, b"\x01" + commanded[:7]),
        Outgoing(60160, b"\x02" + commanded[7:].ljust(7, b"\xff")),
    )
    wanted = (THEIRS, THEIRS + 1) if node.name < device.own_name else (THEIRS + 1, THEIRS)
    await until(lambda: (node.address, device.address) == wanted, "they have two addresses")
    await until(lambda: device.ready and node.operating, "and both may speak")


def test_both_claim_an_address_and_read_each_others_product_information(tmp_path: Path) -> None:
    async def scene() -> None:
        port = free_port()
        url = f"loop://devices-{port}"
        async with a_gateway(url, port) as (gateway, _), a_device(over_text(port), tmp_path) as device:
            await they_know_each_other(gateway, device, url)

    asyncio.run(scene())


@pytest.mark.parametrize(("device_class", "lower"), [(20, True), (120, False)], ids=["lower", "higher"])
def test_of_two_that_contend_for_one_address_the_lower_name_gets_it(
    tmp_path: Path, device_class: int, lower: bool
) -> None:
    async def scene() -> None:
        port = free_port()
        url = f"loop://devices-{port}"
        async with a_gateway(url, port, device_class) as (_, node), a_device(over_text(port), tmp_path) as device:
            assert (node.name < device.own_name) == lower
            await they_contend(node, device, url)

    asyncio.run(scene())


def test_the_devices_of_a_bus_are_listed(tmp_path: Path) -> None:
    async def scene() -> bytes:
        port = free_port()
        async with (
            a_gateway(f"loop://devices-{port}", port) as (_, node),
            a_device(over_text(port), tmp_path) as device,
        ):
            await until(lambda: device.ready and node.operating, "both have an address")
            arguments = ("devices", f"ydraw+tcp://{HERE}:{port}", "--json", "--seconds", "3")
            return (await asyncio.to_thread(timonel, *arguments)).stdout

    rows = {
        row.address: row for row in map(msgspec.json.Decoder(DeviceShown).decode, asyncio.run(scene()).splitlines())
    }
    assert {ADDRESS, THEIRS} <= rows.keys()
    assert [row.model for row in rows.values() if row.ours] == ["timonel devices"]
    theirs = rows[THEIRS]
    assert (theirs.model, theirs.installation, theirs.function) == ("the other one", "mast", "PC Gateway")
    assert (rows[ADDRESS].model, rows[ADDRESS].installation) == ("timonel", "chart table")


CANBOATJS = """
const {FromPgn} = require("@canboat/canboatjs");
const parser = new FromPgn({useCamel: true});
parser.on("error", (pgn, error) => { console.error(error); process.exitCode = 1; });
for (const line of process.argv.slice(1)) console.log(JSON.stringify(parser.parseString(line).fields));
"""


def test_canboatjs_reads_what_we_say_of_ourselves() -> None:
    node = Node(NodeSettings(unique_number=1234, software="1.0"), Sender(ADDRESS), Devices(), 0.0)
    us = node.ourselves()
    assert us is not None
    assert us.product is not None
    assert us.configuration is not None
    lines = [
        f"2026-01-01T00:00:00.000Z,6,{message.PGN},{ADDRESS},255,{len(payload)},{payload.hex(',')}"
        for message in (us.claim, us.product, us.configuration)
        for payload in (message.encode(),)
    ]
    done = subprocess.run(["node", "-e", CANBOATJS, *lines], cwd=NODE, capture_output=True, text=True, check=True)
    claim, product, configuration = map(json.loads, done.stdout.splitlines())
    assert (claim["uniqueNumber"], claim["deviceFunction"], claim["industryGroup"]) == (1234, 130, "Marine Industry")
    assert (product["modelId"], product["softwareVersionCode"]) == ("timonel", "1.0")
    assert configuration["manufacturerInformation"] == "timonel"
