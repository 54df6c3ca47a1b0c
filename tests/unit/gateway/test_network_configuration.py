import asyncio
import re
from pathlib import Path

import pytest

from timonel.errors import ConfigError
from timonel.gateway.assemble import assemble
from timonel.gateway.configuration import parse
from timonel.gateway.machine import describe
from timonel.links.shaped import Shaped
from timonel.links.tcp_listen import TcpListenLink
from timonel.links.text_bus import TextBus
from timonel.nmea0183.selection import Hearing, Selection

DOCS = Path(__file__).parents[3] / "docs"
HEAD = '[vehicle]\nkind = "boat"\n[bus]\nurl = "ydraw+tcp://127.0.0.1:1457"\nnode = false\n'
STATION = HEAD + '[[station]]\nid = 1\nurl = "pty:///tmp/bridge"\n'
OUTPUT = HEAD + '[[output]]\nurl = "tcp-listen://127.0.0.1:0"\n'
INPUT = OUTPUT + '[[input]]\nurl = "iec450://NAVD"\n'
ROVER = '[vehicle]\nkind = "rover"\n[bus]\nurl = "slcan:///dev/x"\n[[station]]\nid = 1\nurl = "serial:///dev/y"\n'

WRONG = [
    (OUTPUT + 'format = "ydrow"', 'output[1].format: "ydrow"'),
    (OUTPUT + "transmit = true", "output[1].transmit: is for frames; say with format"),
    (OUTPUT + 'format = "ydraw"\nframes_per_second = 0', "output[1].frames_per_second: 0"),
    (OUTPUT + 'format = "ydraw"\nsentences = ["HDT"]', "output[1].sentences: is for sentences; with a format"),
    (OUTPUT + 'sentences = ["HTD", "HDTT"]', 'output[1].sentences: "HDTT" is no sentence that we send (did'),
    (OUTPUT + 'except = ["hdt"]', 'output[1].except: "hdt" is no sentence that we send'),
    (OUTPUT + 'sentences = ["HDT"]\nexcept = ["RMC"]', "output[1].except: sentences says already which ones"),
    (STATION + 'except = ["PARP"]', 'station[1].except: "PARP" must reach a station'),
    (STATION + 'except = ["ALR"]', 'station[1].except: "ALR" must reach a station'),
    (OUTPUT + "rates = {PARP = 1}", 'output[1].rates: "PARP" has no rate'),
    (OUTPUT + "rates = {HDT = -1}", "output[1].rates"),
    (OUTPUT + 'talker = "gp"', 'output[1].talker: "gp" is not a talker: two capital letters'),
    (OUTPUT + 'talker = {RMC = "GPS"}', 'output[1].talker: "GPS" is not a talker'),
    (OUTPUT + "bytes_per_second = 10", "output[1].bytes_per_second: 10"),
    (OUTPUT.replace("ydraw+tcp", "ydraw+loop"), "bus.url"),
    (ROVER.replace("slcan:///dev/x", "candump+tcp://h:1"), "bus.url: candump+tcp://h:1: a rover's frames have 11-bit"),
    (INPUT + 'sentences = ["HDX"]', 'input[1].sentences: "HDX" is no sentence that we read'),
    (INPUT + 'sentences = ["HDT"]\nexcept = ["RMC"]', "input[1].except: sentences says already"),
    (INPUT + 'talkers = ["gp"]', 'input[1].talkers: "gp" is not a talker'),
]  # fmt: skip


@pytest.mark.parametrize(("text", "said"), WRONG)
def test_a_mistake_is_named_with_its_key_and_the_remedy(text, said) -> None:
    with pytest.raises(ConfigError) as refusal:
        parse(text)
    assert said in str(refusal.value)


def test_wishes_about_a_port_are_understood() -> None:
    text = 'talker = {RMC = "GP"}\nrates = {RMC = 0.5}\nsentences = ["RMC", "PARP"]\nbytes_per_second = 480'
    [output] = parse(OUTPUT + text).outputs
    assert output.selection == Selection(("RMC", "PARP"), (), None, {"RMC": "GP"}, {"RMC": 0.5})
    assert output.bytes_per_second == 480
    assert parse(OUTPUT + 'talker = "GP"').outputs[0].selection == Selection(talker="GP")


def test_what_is_heard_of_an_input_is_understood_and_is_part_of_the_machine() -> None:
    text = INPUT + 'except = ["GSV"]\ntalkers = ["GP", "HE"]'
    configuration = parse(text)
    assert configuration.inputs[0].port.hears == Hearing(None, ("GSV",), ("GP", "HE"))
    assert parse(INPUT).inputs[0].port.hears is None
    assert '"talkers":["GP","HE"]' in describe(configuration, 0.0)["ports"]


@pytest.mark.parametrize("page", ["opencpn.md", "esp32.md", "links.md", "configuration.md"])
def test_what_the_pages_show_is_understood(page) -> None:
    examples = re.findall(r"```toml\n(.*?)```", (DOCS / page).read_text(), re.DOTALL)
    assert examples
    for example in examples:
        parse(HEAD + "[web]\n" + example)


def links(text: str) -> dict[str, object]:
    async def made() -> dict[str, object]:
        return {link.name: link for link in assemble(parse(text)).links}

    return asyncio.run(made())


def test_a_port_without_wishes_is_not_wrapped_and_a_serial_one_has_the_budget_of_its_line() -> None:
    plain = links(OUTPUT + 'name = "Plain"\n[[output]]\nname = "Line"\nurl = "serial:///dev/ttyS0?baud=4800"')
    assert isinstance(plain["Plain"], TcpListenLink)
    assert isinstance(plain["Line"], Shaped)
    assert plain["Line"]._ration.rate == 480


def test_in_and_out_of_a_station_over_one_link_stay_one_link() -> None:
    made = links(STATION + 'sentences = ["HDT"]\nname = "Bridge"')
    assert set(made) == {"bus", "Bridge"}
    assert isinstance(made["Bridge"], Shaped)


def test_only_what_a_station_hears_is_held_back() -> None:
    text = STATION.replace('url = "pty:///tmp/bridge"', 'in = "serial:///dev/ttyS1"\nout = "serial:///dev/ttyS2"')
    made = links(text + 'name = "Bridge"')
    assert not isinstance(made["Bridge"], Shaped)
    assert isinstance(made["Bridge OUT"], Shaped)


def test_a_rovers_serial_line_carries_frames_and_is_left_alone() -> None:
    assert not isinstance(links(ROVER + 'name = "Jetson"')["Jetson"], Shaped)


def test_what_gave_way_is_in_health() -> None:
    async def scene() -> None:
        gateway = assemble(parse(OUTPUT + 'name = "Plotter"\nbytes_per_second = 480'))
        shaped = gateway.channels[0].send
        shaped.skipped["HDT"] += 3
        assert gateway.health._watched["Plotter skipped"]() == {"HDT": 3}

    asyncio.run(scene())


def test_the_bus_may_be_text_over_any_link_that_carries_bytes() -> None:
    assert isinstance(links(OUTPUT)["bus"], TextBus)


def test_a_text_bus_and_a_port_cannot_share_a_serial_adapter() -> None:
    text = OUTPUT.replace("ydraw+tcp://127.0.0.1:1457", "ydraw+serial:///dev/ttyS9")
    with pytest.raises(ConfigError, match=r"is bus\.url already"):
        parse(text + '[[output]]\nurl = "serial:///dev/ttyS9"')
