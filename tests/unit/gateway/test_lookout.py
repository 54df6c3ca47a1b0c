from timonel.gateway.lookout import Lookout, Request, StationStatus, StatusChanged
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import CommandRequested, CommandTransferred, PilotMode

HOLDING = parp.status(PilotMode.HEADING_HOLD, 455, 44.8, -3.2, 1)


def heard(lookout: Lookout, data: bytes, now: float) -> list[object]:
    return [event for report in lookout.receive(data) for event in lookout.hear(report, now)]


def test_status_is_typed_and_has_an_age():
    lookout = Lookout()
    (event,) = heard(lookout, HOLDING, 5.0)
    status = lookout.status(5.5)
    assert status == StationStatus(PilotMode.HEADING_HOLD, "HEADING_HOLD", 45.5, 44.8, -3.2, 1, 0.5)
    assert event == StatusChanged(lookout.status(5.0))


def test_before_the_first_status_everything_is_unknown_and_stale():
    assert Lookout().status(5.0) == StationStatus()
    assert Lookout().status(5.0).stale


def test_a_status_is_stale_after_three_seconds():
    lookout = Lookout()
    heard(lookout, HOLDING, 5.0)
    assert not lookout.status(7.9).stale
    assert lookout.status(8.0).stale


def test_a_status_that_says_the_same_again_is_no_event():
    lookout = Lookout()
    assert heard(lookout, HOLDING, 5.0)
    assert heard(lookout, HOLDING, 5.5) == []
    assert lookout.status(5.5).age == 0.0


def test_a_transfer_changes_the_commander_before_the_next_status_does():
    lookout = Lookout()
    heard(lookout, HOLDING, 5.0)
    assert heard(lookout, parp.cmdtransfer(1, 2), 5.1) == [CommandTransferred(1, 2)]
    assert lookout.status(5.2).commander == 2


def test_an_announced_request_counts_down():
    lookout = Lookout()
    assert heard(lookout, parp.cmdrequest(3), 5.0) == [CommandRequested(3)]
    assert lookout.requests(7.5) == (Request(3, 7.5),)
    assert lookout.announced(3) == 5.0
    assert lookout.announced(2) is None


def test_an_announced_request_is_forgotten_when_it_must_have_been_denied():
    lookout = Lookout(request_seconds=10.0)
    heard(lookout, parp.cmdrequest(3), 5.0)
    assert lookout.requests(15.9) == (Request(3, 0.0),)
    assert lookout.requests(16.0) == ()


def test_a_transfer_ends_what_was_announced():
    lookout = Lookout()
    heard(lookout, parp.cmdrequest(3) + parp.cmdtransfer(1, 3), 5.0)
    assert lookout.requests(5.0) == ()


def test_the_wrong_check_sums_of_printed_examples_are_dropped_and_counted():
    lookout = Lookout()
    printed = b"$PARP,STATUS,HEADING_HOLD,045.5,044.8,-3.2,01*4F\r\n$PARP,CMDTRANSFER,01,02*3A\r\n"
    assert heard(lookout, printed, 5.0) == []
    assert lookout.rejected == {"wrong check sum": 2}
    assert lookout.status(5.0) == StationStatus()


def test_other_sentences_and_noise_are_passed_over():
    lookout = Lookout()
    noise = b"\xff\x00$IIHDT,182.3,T*21\r\n!AIVDM,1,1,,A,13aG,0*00\r\n"
    assert heard(lookout, noise + HOLDING[:9], 5.0) == []
    assert len(heard(lookout, HOLDING[9:], 5.0)) == 1
    assert not lookout.rejected


def test_a_mode_that_is_not_in_the_protocol_is_unknown_and_kept_as_text():
    lookout = Lookout()
    sentence = b"PARP,STATUS,WIND,,,,00"
    checksum = 0
    for byte in sentence:
        checksum ^= byte
    heard(lookout, b"$%s*%02X\r\n" % (sentence, checksum), 5.0)
    status = lookout.status(5.0)
    assert (status.mode, status.mode_text, status.setpoint_deg, status.commander) == (None, "WIND", None, 0)
