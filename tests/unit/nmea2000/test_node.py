"""What a node answers, asks and can be told."""

import pytest

from tests.unit.nmea2000.bus import Bus, End
from timonel.core.message import Message
from timonel.nmea2000 import registry
from timonel.nmea2000.claim import AddressClaimed, with_instance
from timonel.nmea2000.identifier import Identifier
from timonel.nmea2000.lookups import (
    GroupFunction,
    IsoControl,
    NewPriority,
    ParameterError,
    PgnErrorCode,
    PgnListFunction,
    TransmissionIntervalError,
)
from timonel.nmea2000.messages.group_function import (
    NmeaAcknowledgeGroupFunction,
    NmeaCommandGroupFunction,
    NmeaReadFieldsGroupFunction,
    NmeaReadFieldsReplyGroupFunction,
    NmeaRequestGroupFunction,
    NmeaWriteFieldsGroupFunction,
    NmeaWriteFieldsReplyGroupFunction,
    Parameter,
    command,
)
from timonel.nmea2000.messages.network import (
    ConfigurationInformation,
    Heartbeat,
    IsoAcknowledgement,
    IsoAddressClaim,
    IsoRequest,
    PgnListTransmitAndReceive,
    ProductInformation,
)
from timonel.nmea2000.messages.steering import HeadingTrackControl, Rudder
from timonel.nmea2000.node import ANSWERS, Described, NodeSettings
from timonel.nmea2000.sender import Outgoing, outgoing

OURS = NodeSettings(unique_number=1234, software="1.2", installation1="locker")
PLOTTER = 7
OK = ParameterError.ACKNOWLEDGE


class Scene:
    """A node that has its address, and a plotter that talks to it."""

    def __init__(self, settings: NodeSettings | None = OURS) -> None:
        self.end = End(settings)
        self.bus = Bus(self.end)
        self.bus.run(1.0)
        self.end.happened.clear()
        self.bus.said.clear()

    def asked(self, message: Message, destination: int = 35, source: int = PLOTTER) -> list[Message | None]:
        """What it says to that at once."""
        return [words for _, words in self.answers(message, destination, source)]

    def answers(
        self, message: Message, destination: int = 35, source: int = PLOTTER
    ) -> list[tuple[Identifier, Message | None]]:
        said = self.bus.say(message, source, destination)
        return [(target, registry.decode(target.pgn, payload)) for target, payload in said]

    @property
    def configuration(self) -> ConfigurationInformation:
        (words,) = self.asked(IsoRequest(pgn=126998))
        assert isinstance(words, ConfigurationInformation)
        return words


def acknowledged(
    pgn: int,
    *parameters: ParameterError,
    error: PgnErrorCode = PgnErrorCode.ACKNOWLEDGE,
    interval: TransmissionIntervalError = TransmissionIntervalError.ACKNOWLEDGE,
) -> NmeaAcknowledgeGroupFunction:
    return NmeaAcknowledgeGroupFunction(
        pgn=pgn,
        pgn_error_code=error,
        transmission_interval_priority_error_code=interval,
        number_of_parameters=len(parameters),
        parameters=parameters,
    )


def refused(parameter: ParameterError, pgn: int = 126998) -> list[NmeaAcknowledgeGroupFunction]:
    return [acknowledged(pgn, parameter)]


# ISO requests ------------------------------------------------------------------------------------------


def test_product_information_is_told_to_everybody_whoever_asked() -> None:
    scene = Scene()
    for destination in (35, 255):
        ((target, words),) = scene.answers(IsoRequest(pgn=126996), destination)
        assert (target.source, target.destination, target.priority) == (35, 255, 6)
        assert isinstance(words, ProductInformation)
        assert (words.model_id, words.software_version_code, words.model_serial_code) == ("timonel", "1.2", "1234")
        assert (words.nmea2000_version, words.load_equivalency) == (2.1, 1)


def test_configuration_information_says_what_the_installer_wrote() -> None:
    assert Scene().configuration.installation_description1 == "locker"


def test_the_lists_tell_what_it_sends_and_understands_to_the_one_who_asked() -> None:
    scene = Scene()
    scene.end.node.sent(outgoing(Rudder.decode(b"")))
    sends, obeys = scene.answers(IsoRequest(pgn=126464))
    assert sends[0].destination == obeys[0].destination == PLOTTER
    assert isinstance(sends[1], PgnListTransmitAndReceive)
    assert isinstance(obeys[1], PgnListTransmitAndReceive)
    assert (sends[1].function_code, obeys[1].function_code) == (PgnListFunction.TRANSMIT, PgnListFunction.RECEIVE)
    assert sends[1].pgns == (59392, 59904, 60928, 126208, 126464, 126993, 126996, 126998, 127245)
    assert 65240 in obeys[1].pgns


def test_a_heartbeat_comes_when_asked_and_every_minute() -> None:
    scene = Scene()
    (words,) = scene.asked(IsoRequest(pgn=126993))
    assert isinstance(words, Heartbeat)
    assert (words.data_transmit_offset, words.sequence_counter) == (60.0, 1)
    scene.bus.said.clear()
    scene.bus.run(180.0)
    beats = [(round(now), payload[2]) for now, _, payload in scene.bus.heard(126993)]
    assert beats == [(61, 2), (121, 3)]


def test_the_counter_of_the_heartbeat_begins_anew_after_252() -> None:
    scene = Scene()
    counted: list[int | None] = []
    for second in range(260):
        scene.bus.run(2.0 + second)
        (words,) = scene.asked(IsoRequest(pgn=126993))
        assert isinstance(words, Heartbeat)
        counted.append(words.sequence_counter)
    assert set(counted) == set(range(253))


def test_what_we_have_not_is_denied_to_the_one_who_asked_us() -> None:
    scene = Scene()
    ((target, words),) = scene.answers(IsoRequest(pgn=130306))
    assert target.destination == PLOTTER
    assert words == IsoAcknowledgement(control=IsoControl.NAK, group_function=None, pgn=130306)


@pytest.mark.parametrize(("source", "destination"), [(PLOTTER, 255), (254, 35), (PLOTTER, 36)])
def test_nobody_is_told_no_who_did_not_ask_us(source: int, destination: int) -> None:
    assert Scene().asked(IsoRequest(pgn=130306), destination, source) == []


def test_what_is_sent_over_and_over_is_sent_once_more_when_asked_for() -> None:
    scene = Scene()
    rudder = Outgoing(127245, bytes(8))
    scene.end.node.now = 1.0
    scene.end.node.sent(rudder)
    assert scene.asked(IsoRequest(pgn=127245)) == [Rudder.decode(bytes(8))]
    scene.bus.run(4.1)
    (words,) = scene.asked(IsoRequest(pgn=127245))
    assert isinstance(words, IsoAcknowledgement)


def test_an_order_to_the_pilot_is_never_repeated_for_somebody_who_asks() -> None:
    scene = Scene()
    scene.end.node.sent(outgoing(HeadingTrackControl.decode(b"")))
    (words,) = scene.asked(IsoRequest(pgn=127237))
    assert isinstance(words, IsoAcknowledgement)
    (words,) = scene.asked(NmeaRequestGroupFunction(pgn=127237))
    assert words == acknowledged(127237, error=PgnErrorCode.ACCESS_DENIED)


def test_a_flood_of_questions_gets_so_many_answers_a_second() -> None:
    scene = Scene()
    scene.bus.run(2.0)
    answers = [scene.asked(IsoRequest(pgn=126996)) + scene.asked(NmeaRequestGroupFunction(pgn=1)) for _ in range(100)]
    assert sum(map(len, answers)) == ANSWERS


def test_nothing_is_answered_without_an_address() -> None:
    end = End(OURS)
    bus = Bus(end)
    bus.run(0.4)
    for question in (IsoRequest(pgn=126996), NmeaRequestGroupFunction(pgn=126996)):
        assert bus.say(question, PLOTTER, end.node.address) == []


def test_without_settings_it_knows_who_is_there_and_says_nothing() -> None:
    scene = Scene(None)
    assert scene.bus.claim(5, 35) == []
    assert scene.bus.claim(6, PLOTTER) == []
    assert scene.asked(IsoRequest(pgn=126996)) == []
    scene.bus.run(100.0)
    assert {target.source for _, target, _ in scene.bus.said} <= {35, PLOTTER}
    assert [device.address for device in scene.end.devices.all] == [PLOTTER, 35]
    assert (scene.end.node.address, scene.end.node.operating) == (35, True)
    assert scene.end.node.name == NodeSettings().name


# What it asks others -----------------------------------------------------------------------------------


def test_a_new_device_is_asked_what_it_is_three_times_at_most() -> None:
    scene = Scene()
    scene.bus.claim(5, PLOTTER)
    scene.bus.run(20.0)
    asked = [(target.destination, int.from_bytes(payload, "little")) for _, target, payload in scene.bus.heard(59904)]
    assert asked == [(PLOTTER, 126996), (PLOTTER, 126998)] * 3


def test_a_device_that_answers_is_asked_no_more() -> None:
    one, other = End(OURS), End(NodeSettings(unique_number=7, model="other", installation1="mast"))
    bus = Bus(one, other)
    bus.run(20.0)
    device = one.devices.at(36)
    assert device is not None
    assert device.product is not None
    assert device.configuration is not None
    assert (device.product.model_id, device.configuration.installation_description1) == ("other", "mast")
    scan = 1
    assert len([target for _, target, _ in bus.heard(59904) if target.destination == 36]) == 2
    assert len([target for _, target, _ in bus.heard(59904) if target.destination == 255]) == 2 * scan


def test_a_flood_of_names_costs_four_questions_a_second() -> None:
    scene = Scene()
    for second in range(10):
        for number in range(200):
            scene.bus.claim(1 << 40 | second << 20 | number, 100 + number % 100)
        scene.bus.run(2.0 + second)
    assert len(scene.bus.heard(59904)) <= 40


# Group functions ---------------------------------------------------------------------------------------


def test_a_request_gives_the_pgn_itself() -> None:
    ((target, words),) = Scene().answers(NmeaRequestGroupFunction(pgn=126996))
    assert target.destination == 255
    assert isinstance(words, ProductInformation)


def test_a_request_that_everybody_hears_is_answered_without_an_acknowledgement() -> None:
    scene = Scene()
    assert len(scene.asked(NmeaRequestGroupFunction(pgn=60928), destination=255)) == 1
    assert scene.asked(NmeaRequestGroupFunction(pgn=130306), destination=255) == []
    assert scene.asked(NmeaRequestGroupFunction(pgn=60928), source=254) == []


def test_a_request_for_what_we_have_not_is_acknowledged_so() -> None:
    scene = Scene()
    ((target, words),) = scene.answers(NmeaRequestGroupFunction(pgn=130306))
    assert (target.destination, words) == (PLOTTER, acknowledged(130306, error=PgnErrorCode.PGN_NOT_SUPPORTED))
    assert isinstance(words, NmeaAcknowledgeGroupFunction)
    assert words.function_code is GroupFunction.ACKNOWLEDGE


def test_a_request_may_say_what_the_pgn_must_hold() -> None:
    scene = Scene()
    ours = Parameter(5, OURS.device_function.to_bytes(1, "little"))
    (words,) = scene.asked(NmeaRequestGroupFunction(pgn=60928, parameters=(ours,)))
    assert isinstance(words, IsoAddressClaim)
    (words,) = scene.asked(NmeaRequestGroupFunction(pgn=60928, parameters=(Parameter(5, b"\x96"),)))
    assert words == acknowledged(60928, ParameterError.PARAMETER_OUT_OF_RANGE)
    (words,) = scene.asked(NmeaRequestGroupFunction(pgn=60928, parameters=(Parameter(11, b""),)))
    assert words == acknowledged(60928, ParameterError.INVALID_PARAMETER_FIELD)


def test_the_interval_of_the_heartbeat_may_be_changed() -> None:
    scene = Scene()
    words = scene.asked(NmeaRequestGroupFunction(pgn=126993, transmission_interval=5.0))
    assert words[0] == acknowledged(126993)
    assert isinstance(words[1], Heartbeat)
    assert words[1].data_transmit_offset == 5.0
    scene.bus.said.clear()
    scene.bus.run(21.5)
    assert len(scene.bus.heard(126993)) == 4
    default = bytes((0,)) + (126993).to_bytes(3, "little") + (0xFFFFFFFE).to_bytes(4, "little") + b"\xff\xff\x00"
    (_, beat) = scene.bus.say(Outgoing(126208, default, 35), PLOTTER)
    assert Heartbeat.decode(beat[1]).data_transmit_offset == 60.0


@pytest.mark.parametrize(
    ("pgn", "seconds", "error"),
    [
        (126993, 0.0, TransmissionIntervalError.TRANSMIT_INTERVAL_TOO_LOW),
        (126993, 0.999, TransmissionIntervalError.TRANSMIT_INTERVAL_TOO_LOW),
        (126993, 60.001, TransmissionIntervalError.TRANSMIT_INTERVAL_PRIORITY_NOT_SUPPORTED),
        (126996, 10.0, TransmissionIntervalError.TRANSMIT_INTERVAL_PRIORITY_NOT_SUPPORTED),
    ],
)
def test_other_intervals_are_not(pgn: int, seconds: float, error: TransmissionIntervalError) -> None:
    (words,) = Scene().asked(NmeaRequestGroupFunction(pgn=pgn, transmission_interval=seconds))
    assert words == acknowledged(pgn, interval=error)


def test_a_plotter_writes_installation_descriptions() -> None:
    scene = Scene()
    lau = (bytes((6, 1)) + b"mast", "Böot".encode("utf-16-le"))
    parameters = (Parameter(1, lau[0]), Parameter(2, bytes((2 + len(lau[1]), 0)) + lau[1]))
    changed = NmeaCommandGroupFunction(pgn=126998, parameters=parameters)
    assert scene.asked(changed) == [acknowledged(126998, OK, OK)]
    assert scene.end.happened == [Described("mast", "Böot")]
    told = scene.configuration
    assert (told.installation_description1, told.installation_description2) == ("mast", "Böot")


@pytest.mark.parametrize(
    ("parameter", "error"),
    [
        (Parameter(3, b"\x03\x01x"), ParameterError.ACCESS_DENIED),
        (Parameter(1, b"\x02\x07"), ParameterError.PARAMETER_OUT_OF_RANGE),
        (Parameter(1, bytes((101, 1)) + b"x" * 99), ParameterError.PARAMETER_OUT_OF_RANGE),
    ],
)
def test_what_may_not_be_written_changes_nothing(parameter: Parameter, error: ParameterError) -> None:
    scene = Scene()
    sound = Parameter(2, b"\x03\x01x")
    asked = NmeaCommandGroupFunction(pgn=126998, parameters=(sound, parameter))
    assert scene.asked(asked) == [acknowledged(126998, OK, error)]
    assert scene.end.happened == []
    assert scene.configuration.installation_description2 is None


def test_a_field_that_there_is_not_is_invalid() -> None:
    asked = NmeaCommandGroupFunction(pgn=126998, parameters=(Parameter(9, b"\x00"),))
    assert Scene().asked(asked) == refused(ParameterError.INVALID_PARAMETER_FIELD)


def test_another_priority_is_not_taken_and_then_nothing_is() -> None:
    scene = Scene()
    parameters = (Parameter(1, b"\x03\x01x"),)
    asked = NmeaCommandGroupFunction(pgn=126998, priority=NewPriority.PRIORITY_2, parameters=parameters)
    error = TransmissionIntervalError.TRANSMIT_INTERVAL_PRIORITY_NOT_SUPPORTED
    assert scene.asked(asked) == [acknowledged(126998, OK, interval=error)]
    assert scene.end.happened == []


def test_instances_are_commanded_and_the_address_claimed_under_the_new_name() -> None:
    scene = Scene()
    asked = command(IsoAddressClaim, device_instance_lower=3, device_instance_upper=1, system_instance=2)
    words = scene.answers(asked)
    name = with_instance(OURS.name, 11) | 2 << 56
    assert words[0][1] == acknowledged(60928, OK, OK, OK)
    assert words[1][0].pgn == 60928
    scene.bus.run(2.0)
    assert scene.end.happened == [AddressClaimed(35, name)]


def test_a_name_that_stays_is_not_claimed_anew() -> None:
    scene = Scene()
    assert scene.asked(command(IsoAddressClaim, device_instance_lower=0)) == [acknowledged(60928, OK)]
    assert scene.end.node.operating


def test_what_a_device_is_cannot_be_commanded() -> None:
    asked = command(IsoAddressClaim, device_function=150)
    assert Scene().asked(asked) == refused(ParameterError.ACCESS_DENIED, 60928)


def test_nobody_commands_the_steering_over_the_bus() -> None:
    asked = command(HeadingTrackControl, heading_to_steer_course=1.0)
    error = PgnErrorCode.ACCESS_DENIED
    assert Scene().asked(asked) == [acknowledged(127237, *(OK for _ in asked.parameters), error=error)]


def test_fields_are_read() -> None:
    scene = Scene()
    asked = NmeaReadFieldsGroupFunction(pgn=126998, unique_id=9, parameters=(1, 3))
    (words,) = scene.asked(asked)
    assert isinstance(words, NmeaReadFieldsReplyGroupFunction)
    assert words.unique_id == 9
    assert words.parameters == (Parameter(1, b"\x08\x01locker"), Parameter(3, b"\x09\x01timonel"))


def test_fields_of_another_device_or_that_are_not_there_are_not_read() -> None:
    scene = Scene()
    elsewhere = Parameter(1, b"\x03\x01x")
    no = PgnErrorCode.READ_OR_WRITE_NOT_SUPPORTED
    asked = NmeaReadFieldsGroupFunction(pgn=126998, unique_id=9, selection=(elsewhere,), parameters=(1,))
    assert scene.asked(asked) == [acknowledged(126998, ParameterError.PARAMETER_OUT_OF_RANGE, OK, error=no)]
    asked = NmeaReadFieldsGroupFunction(pgn=126998, unique_id=9, parameters=(4,))
    assert scene.asked(asked) == [acknowledged(126998, ParameterError.INVALID_PARAMETER_FIELD, error=no)]


def test_fields_are_written_and_told_as_they_are_then() -> None:
    scene = Scene()
    value = Parameter(2, b"\x06\x01mast")
    ours = Parameter(1, b"\x08\x01locker")
    (words,) = scene.asked(
        NmeaWriteFieldsGroupFunction(pgn=126998, unique_id=9, selection=(ours,), parameters=(value,))
    )
    assert isinstance(words, NmeaWriteFieldsReplyGroupFunction)
    assert (words.selection, words.parameters) == ((ours,), (value,))
    assert scene.end.happened == [Described("locker", "mast")]


def test_what_is_selected_by_something_else_is_not_written() -> None:
    scene = Scene()
    value, elsewhere = Parameter(2, b"\x06\x01mast"), Parameter(1, b"\x03\x01x")
    asked = NmeaWriteFieldsGroupFunction(pgn=126998, unique_id=9, selection=(elsewhere,), parameters=(value,))
    no = PgnErrorCode.READ_OR_WRITE_NOT_SUPPORTED
    assert scene.asked(asked) == [acknowledged(126998, ParameterError.PARAMETER_OUT_OF_RANGE, OK, error=no)]
    assert scene.end.happened == []


def test_an_acknowledgement_of_somebody_gets_no_answer() -> None:
    scene = Scene()
    assert scene.asked(acknowledged(126998, OK)) == []
    assert scene.asked(IsoAcknowledgement(control=IsoControl.NAK, group_function=None, pgn=126998)) == []
