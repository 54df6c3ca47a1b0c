"""Our node and PyPI `nmea2000`'s device on a bus of the real kernel."""

import asyncio
from functools import partial
from pathlib import Path

import pytest
from nmea2000.device import N2KDevice

from tests.interop.test_n2k_device import a_device, a_gateway, they_contend, they_know_each_other
from tests.program import free_port

URL = "socketcan://vcan0"

pytestmark = pytest.mark.slow


def test_both_claim_an_address_and_read_each_others_product_information(tmp_path: Path) -> None:
    async def scene() -> None:
        on_can = partial(N2KDevice.for_python_can, "socketcan", "vcan0")
        async with a_gateway(URL, free_port()) as (gateway, _), a_device(on_can, tmp_path) as device:
            await they_know_each_other(gateway, device, URL)

    asyncio.run(scene())


@pytest.mark.parametrize("device_class", [20, 120], ids=["lower", "higher"])
def test_of_two_that_contend_for_one_address_the_lower_name_gets_it(tmp_path: Path, device_class: int) -> None:
    async def scene() -> None:
        on_can = partial(N2KDevice.for_python_can, "socketcan", "vcan0")
        async with a_gateway(URL, free_port(), device_class) as (_, node), a_device(on_can, tmp_path) as device:
            await they_contend(node, device, URL)

    asyncio.run(scene())
