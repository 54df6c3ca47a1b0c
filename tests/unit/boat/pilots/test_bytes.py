"""What the drivers send, byte for byte: as recorded control heads sent it, where a recording has it."""

from functools import cache

import pytest

from tests.conformance.recorded import messages
from tests.recordings import recording
from tests.unit.boat.pilots.at_sea import AtSea
from timonel.nmea0183.checksum import verify
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.lookups import SeatalkKey, SimnetApEvent
from timonel.nmea2000.messages.navico import SimnetApCommand
from timonel.nmea2000.sender import Outgoing, Sender
from timonel.vehicles.boat.pilot import Manner, tenths
from timonel.vehicles.boat.pilots import raymarine

SAMPLES = "canboat_canboat/samples/"


@cache
def recorded(name):
    """Every (PGN, priority, is it to one device, payload) of a recording."""
    found = set()
    for message in messages(recording(SAMPLES + name)):
        target = split(message.identifier)
        found.add((target.pgn, target.priority, target.destination != 255, message.payload.hex()))
    return found


def sent(outgoing: Outgoing):
    """The same of a message of ours, as its frames carry it."""
    reassembler, payload = Reassembler(), None
    frames = Sender(0x23).frames(outgoing)
    target = split(frames[0].identifier)
    for frame in frames:
        whole = reassembler.receive(frame.identifier, frame.data, 0.0) if len(frames) > 1 else frame.data
        payload = whole or payload
    assert payload is not None
    return target.pgn, target.priority, target.destination != 255, payload.hex()


def driver(kind, address=None, **settings):
    """The driver of a boat under way, whose pilot is at an address."""
    afloat = AtSea(kind, heading_reference="magnetic", **settings)
    if address is not None:
        afloat.dialect.address = address
        afloat.sea.__init__(dialect=afloat.dialect, heading=0.785)
    afloat.in_command()
    return afloat, afloat.boat.steering.driver


def told(kind, setpoint, manner=Manner.COURSE, address=None, engaged=False):
    """What a driver makes of one order."""
    afloat, made = driver(kind, address)
    if engaged:
        afloat.say(Verb.ENGAGE)
        afloat.run(2.0)
    return list(made.steer(setpoint, 45.0, afloat.now, manner))


# Raymarine ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["pgn65379.raw", "raymarine-ev1.raw"])
def test_an_evolution_is_engaged_and_let_go_as_its_control_head_does_it(name):
    (engage,) = told("raymarine", 450, Manner.ENGAGE)
    (release,) = told("raymarine", None)
    assert sent(engage) in recorded(name)
    assert sent(release) in recorded(name)


@pytest.mark.parametrize("lo_hi", ["c1f2", "61f2", "90eb", "bfe4"])
def test_an_evolutions_course_is_commanded_as_its_control_head_does_it(lo_hi):
    _, made = driver("raymarine")
    raw = int.from_bytes(bytes.fromhex(lo_hi), "little")
    (course,) = made.set_course(tenths(raw * 1e-4 * 57.29577951308232))
    pgn, priority, addressed, payload = sent(course)
    (head,) = [entry for entry in recorded("raymarine-ev1.raw") if entry[3].endswith(lo_hi) and entry[0] == 126208]
    assert (pgn, priority, addressed, payload[:-4]) == (head[0], head[1], head[2], head[3][:-4])
    assert abs(int.from_bytes(bytes.fromhex(payload[-4:]), "little") - raw) <= 9  # our set points are whole tenths


def test_an_evolution_sees_a_control_head_as_it_sees_its_own():
    _, made = driver("raymarine")
    shown = {sent(answer) for which in (0, 1) for answer in made.show(which)}
    assert shown < recorded("raymarine-ev1.raw")


def test_the_course_of_the_specifications_example_is_45_5_degrees():
    _, made = driver("raymarine")
    (course,) = made.set_course(455)
    assert course.payload.hex(" ") == "01 50 ff 00 f8 03 01 3b 07 03 04 06 05 1f"


@pytest.mark.parametrize(
    ("key", "code"),
    [(SeatalkKey.STANDBY, "02 fd"), (SeatalkKey.AUTO, "01 fe"), (SeatalkKey.PLUS_1, "07 f8")],
)
def test_keys_are_those_of_signalk_autopilot(key, code):
    """SignalK/signalk-autopilot: `raymarinen2k.ts` for 22 bytes, `raystngconv.js` for 16; no recording has them."""
    long = f"3b 9f f0 81 86 21 {code} ff ff ff ff ff c1 c2 cd 66 80 d3 42 b1 c8"
    assert raymarine.key(key).payload.hex(" ") == long
    assert raymarine.short_key(key).payload.hex(" ") == f"3b 9f f0 81 86 21 {code} 00 00 00 00 00 00 ff ff"


def test_a_converters_pilot_is_told_by_keys_and_by_its_course():
    (engage,) = told("raymarine-spx", 450, Manner.ENGAGE)
    (release,) = told("raymarine-spx", None)
    assert (engage, release) == (raymarine.short_key(SeatalkKey.AUTO, 93), raymarine.short_key(SeatalkKey.STANDBY, 93))
    (course,) = told("raymarine-spx", 455, engaged=True)
    assert course.payload.hex(" ") == "01 50 ff 00 f8 03 01 3b 07 03 04 06 05 1f"


# Navico -------------------------------------------------------------------------------------------------


def test_ten_degrees_to_starboard_are_those_of_a_recorded_control_head():
    _, made = driver("navico", address=2)
    step, (turn,) = made.change(104)
    assert step == 100
    assert sent(turn) in recorded("sample-single.raw.txt")


def test_heading_mode_and_one_degree_are_those_of_a_recorded_control_head():
    _, made = driver("navico", address=0)
    (engage,) = made.engage()
    assert sent(engage) in recorded("simnet-tp32.raw")
    step, (turn,) = made.change(10)
    pgn, priority, addressed, payload = sent(turn)
    head = (pgn, priority, addressed, payload.replace("af00", "ae00"))  # 0.0174 rad; the nearest to a degree is 0.0175
    assert step == 10
    assert head in recorded("simnet-tp32.raw")


def test_ten_degrees_to_port_are_those_of_the_research_note():
    """canboat `research/navico_alarms_and_commands.md` and pull request 593: `02,D1,06`; no recording has them."""
    _, made = driver("navico", address=2)
    assert made.change(-100)[1][0].payload.hex(" ") == "41 9f 02 ff ff 0a 1a 00 02 d1 06 ff"


def test_standby_is_that_of_canboats_definition_with_00_in_byte_7():
    """canboat `simnetCommandApStandby`, SignalK/signalk-autopilot issue 91; no recording has it."""
    (release,) = told("navico", None)
    assert release.payload.hex(" ") == "41 9f 5d ff ff 0a 06 00 ff ff ff ff"


def test_every_command_to_a_navico_pilot_has_00_in_byte_7():
    _, made = driver("navico")
    said = [*made.engage(), *made.release(), *made.change(55)[1], *made.change(-5)[1]]
    assert {answer.payload[7] for answer in said} == {0}
    assert {len(answer.payload) for answer in said} == {12}


@pytest.mark.parametrize("name", ["simrad_event_timer_start.raw", "susteranna2020.raw"])
def test_the_state_is_asked_for_as_recorded_control_heads_ask(name):
    _, made = driver("navico")
    model = {"simrad_event_timer_start.raw": 1, "susteranna2020.raw": 100}[name]
    made._model = type(made._model)(model)
    assert {sent(answer) for answer in made.show(0)} < recorded(name)


def test_a_command_without_an_address_is_for_every_pilot():
    assert SimnetApCommand(address=None, event=SimnetApEvent.STANDBY).encode()[2] == 0xFF


# Garmin -------------------------------------------------------------------------------------------------

GARMIN = ("garmin-ap-reactor-126720.raw", "boatkit-garmin-autopilot-controls.raw")


@pytest.mark.parametrize("name", GARMIN)
def test_a_reactor_is_engaged_and_let_go_as_its_control_head_does_it(name):
    _, made = driver("garmin")
    assert {sent(answer) for answer in made.engage() + made.release()} < recorded(name)


@pytest.mark.parametrize(("step", "taken"), [(10, 10), (-10, -10), (94, 10), (100, 100), (-250, -100), (96, 100)])
def test_a_reactors_buttons_are_those_of_its_control_head(step, taken):
    _, made = driver("garmin")
    size, (button,) = made.change(step)
    assert size == taken
    assert sent(button) in recorded(GARMIN[1])


def test_a_reactor_sees_a_control_head_as_it_sees_its_own():
    _, made = driver("garmin")
    (heartbeat,) = made.show(0)
    assert sent(heartbeat) in recorded(GARMIN[0])


# Standards ----------------------------------------------------------------------------------------------


def test_a_group_function_commands_the_fields_of_127237_to_one_pilot():
    (hold,) = told("groupfunction", 455)
    (release,) = told("groupfunction", None)
    assert hold.payload.hex(" ") == "01 05 f1 01 f8 03 05 04 07 01 0b 05 1f"
    assert release.payload.hex(" ") == "01 05 f1 01 f8 01 05 00"
    assert (hold.destination, release.destination) == (93, 93)


def test_a_heading_controller_is_told_by_htc_on_its_own_output():
    _, made = driver("sentence")
    orders = [*made.steer(455, 45.0, 0.0, Manner.COURSE), *made.steer(None, 45.0, 0.0, Manner.COURSE)]
    assert [(verify(said.line.strip()), said.key, said.port) for said in orders] == [
        (b"AGHTC,V,,,H,N,,,,,45.5,,,M", "HTC", "Pilot"),
        (b"AGHTC,V,,,M,N,,,,,,,,", "HTC", "Pilot"),
    ]


def test_hsc_tells_both_norths_and_apb_a_track_that_is_never_left():
    afloat, made = driver("sentence", pilot_sentences=("HSC", "APB"))
    heading, track = (said.line.decode().strip()[:-3] for said in made.steer(455, 45.0, afloat.now, Manner.COURSE))
    assert heading == "$AGHSC,47.6,T,45.5,M"
    assert track == "$AGAPB,A,A,0.000,L,N,V,V,45.5,M,COURSE,45.5,M,45.5,M,A"
    assert made.steer(None, 45.0, afloat.now, Manner.COURSE) == []
