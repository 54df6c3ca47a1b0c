import asyncio
import logging
import os
import signal
import socket
from pathlib import Path

import pytest

from tests.unit.gateway.fakes import FakeBus, FakePort, FakeVehicle
from timonel.core.effects import Say
from timonel.gateway.gateway import Channel, Gateway
from timonel.gateway.service import FAILED, serve


def a_gateway(vehicle: FakeVehicle, port: FakePort) -> Gateway:
    return Gateway(vehicle, FakeBus(), [Channel("Bridge", port, port)], flush=5.0)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_after_what_was_waiting_is_sent(number: signal.Signals) -> None:
    async def scene() -> None:
        vehicle, port = FakeVehicle(), FakePort("Bridge")
        vehicle.answers["bytes"] = [Say(b"$IIHDT,1.0,T*1D\r\n", "HDT")]
        serving = asyncio.create_task(serve(a_gateway(vehicle, port)))
        await asyncio.sleep(0.02)
        port.receive(b"$")
        os.kill(os.getpid(), number)
        assert await serving == 0
        assert port.lines == [b"$IIHDT,1.0,T*1D\r\n"]
        assert port.closed == 1

    asyncio.run(scene())


def test_a_gateway_that_gives_up_ends_with_a_status_that_says_so() -> None:
    async def scene() -> None:
        vehicle, port = FakeVehicle(), FakePort("Bridge")
        gateway = a_gateway(vehicle, port)
        serving = asyncio.create_task(serve(gateway))
        await asyncio.sleep(0.02)
        gateway.failed.set()
        assert await serving == FAILED
        assert port.closed == 1

    asyncio.run(scene())


def test_a_signal_while_a_link_is_still_being_opened_ends_it_too() -> None:
    class Unreachable(FakePort):
        async def open(self, *_: object) -> None:
            await asyncio.sleep(60)

    async def scene() -> None:
        serving = asyncio.create_task(serve(a_gateway(FakeVehicle(), Unreachable("Bridge"))))
        await asyncio.sleep(0.02)
        os.kill(os.getpid(), signal.SIGTERM)
        assert await asyncio.wait_for(serving, 5) == 0

    asyncio.run(scene())


def test_a_link_that_fails_in_a_way_nobody_thought_of_ends_it_with_that_fault() -> None:
    class Broken(FakePort):
        async def open(self, *_: object) -> None:
            raise ZeroDivisionError

    async def scene() -> None:
        port = Broken("Bridge")
        with pytest.raises(ZeroDivisionError):
            await serve(a_gateway(FakeVehicle(), port))
        assert port.closed == 1

    asyncio.run(scene())


def test_sigusr1_logs_the_counters(caplog: pytest.LogCaptureFixture) -> None:
    async def scene() -> None:
        gateway = a_gateway(FakeVehicle(), FakePort("Bridge"))
        serving = asyncio.create_task(serve(gateway))
        await asyncio.sleep(0.02)
        os.kill(os.getpid(), signal.SIGUSR1)
        await asyncio.sleep(0.02)
        assert caplog.messages[-1] == "health: nothing heard yet"
        os.kill(os.getpid(), signal.SIGTERM)
        await serving

    caplog.set_level(logging.INFO)
    asyncio.run(scene())


def test_systemd_hears_ready_a_sign_of_life_and_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def scene() -> list[bytes]:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.bind(str(tmp_path / "notify"))
            serving = asyncio.create_task(serve(a_gateway(FakeVehicle(), FakePort("Bridge"))))
            await asyncio.sleep(0.02)
            os.kill(os.getpid(), signal.SIGTERM)
            await serving
            manager.setblocking(False)
            return [manager.recv(100) for _ in range(3)]

    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    monkeypatch.setenv("WATCHDOG_USEC", "60000000")
    assert sorted(asyncio.run(scene())) == [b"READY=1", b"STOPPING=1", b"WATCHDOG=1"]


def test_a_fault_in_a_links_own_callback_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    async def scene() -> None:
        gateway = a_gateway(FakeVehicle(), FakePort("Bridge"))
        serving = asyncio.create_task(serve(gateway))
        await asyncio.sleep(0.02)
        asyncio.get_running_loop().call_soon(lambda: 1 / 0)
        await asyncio.sleep(0.02)
        os.kill(os.getpid(), signal.SIGTERM)
        assert await serving == 0

    asyncio.run(scene())
    assert [record.exc_info is not None for record in caplog.records if record.levelno == logging.ERROR] == [True]
