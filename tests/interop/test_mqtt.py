"""A real broker (mosquitto) is told by the gateway, and its own clients look and give orders."""

import asyncio
import json
import subprocess
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from itertools import pairwise
from math import degrees, radians
from pathlib import Path
from typing import Any

import pytest

from tests.mosquitto import Listener, Mosquitto, tool
from tests.program import Bench, Program, free_port, until
from timonel.nmea0183 import parp
from timonel.nmea2000.lookups import SteeringMode

pytestmark = pytest.mark.timeout(90)

BASE = "timonel/demo"
CERTIFICATES = Path(__file__).parents[1] / "unit" / "web"
BOAT = {
    "heading", "cog", "sog", "stw", "depth", "wind_apparent_speed", "wind_apparent_angle", "wind_true_speed",
    "wind_true_angle", "water_temperature", "rudder", "rate_of_turn", "variation",
}  # fmt: skip
ROVER = {"battery_voltage", "cell1", "cell2", "cell3", "cell4", "wheel_speed", "heading"}


def demo(directory: Path, broker: Mosquitto, *vehicle: str) -> Program:
    port = str(free_port())
    quiet = ("--no-view", "--no-web", "--no-recording", "--port", port, "--directory", str(directory))
    return Program(directory, "demo", *vehicle, *quiet, "--mqtt", broker.url)


def fresh(listener: Listener, keys: set[str]) -> bool:
    standing = listener.standing
    return all(standing.get(f"{BASE}/{key}", {}).get("quality") == "fresh" for key in keys)


@asynccontextmanager
async def everything(
    broker: Mosquitto, directory: Path, keys: set[str], within: float = 20.0
) -> AsyncIterator[Listener]:
    """What somebody learns who subscribes now."""
    async with Listener(broker, directory) as listener:
        await until(lambda: fresh(listener, keys), f"fresh {sorted(keys)}", within)
        yield listener


def test_who_subscribes_late_knows_how_the_boat_stands(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker, demo(tmp_path, broker) as program:
            await program.running()
            async with everything(broker, tmp_path, BOAT):
                pass
            async with everything(broker, tmp_path, BOAT, within=2.0) as late:
                told = {each["topic"]: each for each in reversed(late.heard)}
                assert all(told[f"{BASE}/{key}"]["retain"] == 1 for key in BOAT)
                standing = late.standing
                assert standing[f"{BASE}/availability"] == "online"
                assert standing[f"{BASE}/command"] == {"commander": 0, "name": "", "queue": [], "policy": "transfer"}
                assert standing[f"{BASE}/pilot"]["mode"] == "STANDBY"
                assert standing[f"{BASE}/alerts"] == []
                assert {"name": "bus", "kind": "bus", "connected": True, "reason": ""} in standing[f"{BASE}/links"]
                heading = degrees(late.said(f"{BASE}/heading")[0]["value"])
            said = [float(line.split(",")[1]) for line in program.output_path.read_text().splitlines() if "HDT" in line]
            assert min(abs(heading - each) for each in said) <= 0.051

    asyncio.run(scene())


def test_home_assistant_finds_what_there_is_and_nothing_to_press(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker, demo(tmp_path, broker) as program:
            await program.running()
            async with everything(broker, tmp_path, BOAT) as listener:
                standing = listener.standing
            configs = {topic: config for topic, config in standing.items() if topic.endswith("/config")}
            found = {topic.split("/")[3]: config for topic, config in configs.items()}
            assert found.keys() >= BOAT | {"command", "pilot_mode", "setpoint", "alarm", "alert_101", "bus", "position"}
            assert not [topic for topic in configs if topic.split("/")[1] in ("button", "number", "select")]
            assert len({config["unique_id"] for config in configs.values()}) == len(configs)
            assert {config["device"]["name"] for config in configs.values()} == {"demo"}
            for config in configs.values():
                named = {value for key, value in config.items() if key.endswith("_topic")}
                assert named <= standing.keys()

    asyncio.run(scene())


def test_a_broker_that_starts_anew_is_told_everything_again(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker, demo(tmp_path, broker) as program:
            await program.running()
            async with everything(broker, tmp_path, BOAT):
                pass
            broker.stop()
            await until(lambda: [each for each in program.log() if "MQTT: not connected" in each["text"]], "its end")
            await broker.start()
            async with everything(broker, tmp_path, BOAT) as again:
                await until(lambda: again.standing.get(f"{BASE}/availability") == "online", "online")
                assert len([topic for topic in again.standing if topic.endswith("/config")]) > len(BOAT)

    asyncio.run(scene())


@pytest.mark.parametrize("end", ["killed", "told to stop"])
def test_when_the_gateway_ends_it_is_offline(tmp_path: Path, end: str) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker, demo(tmp_path, broker) as program:
            await program.running()
            async with Listener(broker, tmp_path) as listener:
                await until(lambda: "online" in listener.said(f"{BASE}/availability"), "online")
                if end == "killed":
                    program.kill()
                else:
                    assert await program.stop() < 3.0
                await until(lambda: listener.said(f"{BASE}/availability")[-1] == "offline", "offline")
            async with Listener(broker, tmp_path) as late:
                await until(lambda: f"{BASE}/availability" in late.standing, "what stands")
                assert late.standing[f"{BASE}/availability"] == "offline"

    asyncio.run(scene())


def test_without_a_paired_station_nobody_is_heard(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker, demo(tmp_path, broker) as program:
            await program.running()
            async with everything(broker, tmp_path, BOAT) as listener:
                for verb in ("REQCMD", "TAKECMD", "ENGAGE"):
                    broker.publish(f"{BASE}/order", f'{{"type":"command","id":1,"verb":"{verb}"}}')
                heading = len(listener.said(f"{BASE}/heading"))
                await until(lambda: len(listener.said(f"{BASE}/heading")) > heading + 2, "news after the orders")
                assert listener.said(f"{BASE}/answer") == []
                assert {document["commander"] for document in listener.said(f"{BASE}/command")} == {0}
            assert not [record for record in program.log() if record.get("event") in ("Transferred", "fault")]

    asyncio.run(scene())


def test_a_rover_tells_its_battery_its_wheels_and_its_drives(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker, demo(tmp_path, broker, "rover") as program:
            await program.running()
            async with everything(broker, tmp_path, ROVER) as listener:
                standing = listener.standing
            cells = [standing[f"{BASE}/cell{number}"]["value"] for number in range(1, 5)]
            assert sum(cells) == pytest.approx(standing[f"{BASE}/battery_voltage"]["value"], abs=0.01)
            assert all(3.0 < cell < 4.3 for cell in cells)
            assert standing[f"{BASE}/wheel_speed"]["value"] == pytest.approx(0.0, abs=1.0)
            assert standing[f"{BASE}/drive"]["permitted"] is False
            assert standing[f"{BASE}/position"]["latitude"] == pytest.approx(52.2, abs=0.1)
            entities = {topic.split("/")[3] for topic in standing if topic.endswith("/config")}
            assert entities >= ROVER | {"drives", "battery_state", "alarm", "alert_206"}

    asyncio.run(scene())


# Orders of a paired station ----------------------------------------------------------------------------------------


@asynccontextmanager
async def paired(directory: Path) -> AsyncIterator[tuple[Mosquitto, Bench, Listener]]:
    """A boat whose station 3 is paired with the broker."""
    async with Mosquitto(directory) as broker:
        more = f'[mqtt]\nurl = "{broker.url}"\nstation = 3\nbase = "{BASE}"\ninterval = 0.5'
        async with Bench(directory, more=more) as bench, Listener(broker, directory) as listener:
            await until(lambda: "online" in listener.said(f"{BASE}/availability"), "online")
            yield broker, bench, listener


numbers: Iterator[int] = iter(range(1, 1000))


async def order(broker: Mosquitto, listener: Listener, verb: str, **more: Any) -> dict[str, Any]:
    """Order something as station 3, and how that ended."""
    number = next(numbers)
    parameter = "".join(f',"{name}":{value}' for name, value in more.items())
    broker.publish(f"{BASE}/order", f'{{"type":"command","id":{number},"verb":"{verb}"{parameter}}}')

    def ends() -> list[dict[str, Any]]:
        answers = listener.said(f"{BASE}/answer")
        return [each for each in answers if each["id"] == number and each["outcome"] != "sent"]

    await until(ends, f"how {verb} ended")
    return ends()[0]


def test_a_paired_station_steers_while_it_is_in_command(tmp_path: Path) -> None:
    async def scene() -> None:
        async with paired(tmp_path) as (broker, bench, listener):
            assert (await order(broker, listener, "REQCMD"))["outcome"] == "confirmed"
            await listener.hears(f"{BASE}/command", commander=3, name="Station 3")
            await order(broker, listener, "ENGAGE")
            await listener.hears(f"{BASE}/pilot", mode="HEADING_HOLD")
            await order(broker, listener, "STBDTEN")
            await order(broker, listener, "SETHEADING", parameter=radians(45))
            await listener.hears(f"{BASE}/pilot", setpoint=pytest.approx(radians(45), abs=1e-4))
            courses = [course for _, mode, course in bench.bus.commands() if mode is SteeringMode.HEADING_CONTROL]
            assert list(dict.fromkeys(courses)) == [182.5, 192.5, 45.0]

    asyncio.run(scene())


def test_a_station_that_lost_command_is_refused_and_that_is_told(tmp_path: Path) -> None:
    async def scene() -> None:
        async with paired(tmp_path) as (broker, bench, listener):
            assert (await order(broker, listener, "REQCMD"))["outcome"] == "confirmed"
            await bench.ask(1, parp.command(parp.Verb.TAKECMD, 1), "$PARP,CMDTRANSFER,03,01")
            answer = await order(broker, listener, "ENGAGE")
            assert (answer["outcome"], answer["reason"]) == ("refused", "not in command")
            await listener.hears(f"{BASE}/event", kind="refused", text="station 3 refused: not in command")
            await listener.hears(f"{BASE}/command", commander=1)
            assert bench.bus.commands() == []

    asyncio.run(scene())


def test_what_is_no_order_is_refused_and_changes_nothing(tmp_path: Path) -> None:
    async def scene() -> None:
        async with paired(tmp_path) as (broker, bench, listener):
            request = '{"type":"command","id":1,"verb":"REQCMD"}'
            broker.publish(f"{BASE}/order", request, "-r")
            for nonsense in ("", "REQCMD", "[" * 2000, '{"type":"stick","n":1,"x":1,"y":1}', '{"type":"stop","id":1}'):
                broker.publish(f"{BASE}/order", nonsense)
            broker.publish(f"{BASE}/order", request + " " * 5000)  # more than a message may have
            await until(lambda: len(told(listener)) >= 6, "what is said about them")
            assert "an order must not be retained" in told(listener)
            assert (await order(broker, listener, "ENGAGE"))["outcome"] == "refused"
            assert {document["commander"] for document in listener.said(f"{BASE}/command")} == {0}
            assert bench.bus.commands() == []
            assert not [record for record in bench.program.log() if record.get("event") == "fault"]

    asyncio.run(scene())


def told(listener: Listener) -> list[str]:
    return [event["text"] for event in listener.said(f"{BASE}/event") if event["kind"] == "refused"]


def test_a_retained_order_of_yesterday_is_not_obeyed_today(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker:
            broker.publish(f"{BASE}/order", '{"type":"command","id":1,"verb":"REQCMD"}', "-r")
            async with Listener(broker, tmp_path) as listener:
                more = f'[mqtt]\nurl = "{broker.url}"\nstation = 3\nbase = "{BASE}"'
                async with Bench(tmp_path, more=more):
                    await until(lambda: "online" in listener.said(f"{BASE}/availability"), "online")
                    await order(broker, listener, "DISENGAGE")  # it listens
                    assert {document["commander"] for document in listener.said(f"{BASE}/command")} == {0}

    asyncio.run(scene())


ROVER_TOML = """[vehicle]
kind = "rover"
name = "demo"
[bus]
url = "loop://{bus}"
[[station]]
id = 1
url = "tcp-listen://127.0.0.1:{port}"
[mqtt]
url = "{broker}"
base = "timonel/demo"
station = 2
"""


def test_a_rover_is_stopped_by_a_paired_station_and_moved_by_none(tmp_path: Path) -> None:
    async def scene() -> None:
        async with Mosquitto(tmp_path) as broker:
            path = tmp_path / "rover.toml"
            path.write_text(ROVER_TOML.format(bus=tmp_path.name, port=free_port(), broker=broker.url))
            async with Program(tmp_path, "run", str(path)) as program, Listener(broker, tmp_path) as listener:
                await program.running()
                await until(lambda: "online" in listener.said(f"{BASE}/availability"), "online")
                for number, order in enumerate(('{"type":"stop","id":1}', '{"type":"enable","id":2}'), 1):
                    broker.publish(f"{BASE}/order", order)
                    await until(lambda n=number: len(words(listener)) >= n, order)
                assert words(listener) == ["confirmed", "refused"]
                assert {drive["permitted"] for drive in listener.said(f"{BASE}/drive")} == {False}

    asyncio.run(scene())


def words(listener: Listener) -> list[str]:
    """What was said about orders, in the order in which it was said."""
    told = [each for each in listener.heard if each["topic"] in (f"{BASE}/answer", f"{BASE}/event")]
    documents = [json.loads(each["payload"]) for each in told]
    said = [document.get("outcome", document.get("kind")) for document in documents]
    return [word for word in said if word in ("confirmed", "unconfirmed", "refused")]


def test_a_broker_that_wants_a_password_gets_it_by_tls(tmp_path: Path) -> None:
    async def scene() -> None:
        passwords = tmp_path / "passwords"
        passwords.write_text("boat:correct horse\n")
        subprocess.run([tool("mosquitto_passwd"), "-U", str(passwords)], check=True)
        tls = f"certfile {CERTIFICATES / 'localhost.pem'}\nkeyfile {CERTIFICATES / 'localhost.key'}\n"
        async with Mosquitto(tmp_path, f"{tls}password_file {passwords}\nuser root\n") as broker:
            for directory, password in (("right", "correct horse"), ("wrong", "battery staple")):
                await secured(tmp_path / directory, broker, password)

    asyncio.run(scene())


async def secured(directory: Path, broker: Mosquitto, password: str) -> None:
    """A gateway that comes through with the right password, and says why not with a wrong one."""
    directory.mkdir()
    (directory / "secret").write_text(password)
    path = directory / "rover.toml"
    secure = f"mqtts://localhost:{broker.port}"
    more = f'user = "boat"\npassword_file = "secret"\nauthorities = "{CERTIFICATES / "localhost.pem"}"\n'
    path.write_text(ROVER_TOML.format(bus=directory.name, port=free_port(), broker=secure) + more)
    expected = "MQTT: connected" if directory.name == "right" else "Not authorized"
    async with Program(directory, "run", str(path)) as program:
        await until(lambda: any(expected in record["text"] for record in program.log()), expected)
        assert password not in program.log_path.read_text()


def test_a_broker_that_stands_still_delays_no_station(tmp_path: Path) -> None:
    """STATUS comes twice a second, whatever the broker does."""

    async def scene() -> None:
        async with paired(tmp_path) as (broker, bench, listener):
            broker.freeze(True)
            began = len(bench.outs[2].heard)
            await asyncio.sleep(8.0)  # until it is given up
            broker.freeze(False)
            times = [time for time, line in bench.outs[2].heard[began:] if line.startswith("$PARP,STATUS")]
            assert len(times) >= 15
            assert max(later - sooner for sooner, later in pairwise(times)) < 0.75
            assert (await order(broker, listener, "REQCMD"))["outcome"] == "confirmed"

    asyncio.run(scene())


def test_a_gateway_without_its_broker_runs_and_ends(tmp_path: Path) -> None:
    async def scene() -> None:
        nobody = Mosquitto(tmp_path)
        async with demo(tmp_path, nobody) as program:
            await program.running()
            await until(lambda: [each for each in program.log() if "MQTT: not connected" in each["text"]], "a word")
            assert await program.stop() < 2.0

    asyncio.run(scene())
