"""The current sensors' zeros are what they read at rest."""

import struct

from timonel.vehicles.rover.autozero import READINGS, AutoZero
from timonel.vehicles.rover.calibration import PHYSICAL
from timonel.vehicles.rover.frames import MotorCurrentLeft
from timonel.vehicles.rover.protocol import Protocol

READ = struct.pack("<3h", 1858, 1862, 1866)


def test_after_a_second_at_rest_no_current_reads_as_none():
    zero = AutoZero()
    for _ in range(READINGS):
        zero.receive(105, READ)
    found = Protocol(zero.zeroed(PHYSICAL)).decode(105, READ)
    assert found == MotorCurrentLeft(front=0.0, middle=0.0, rear=0.0)


def test_noise_is_averaged():
    zero = AutoZero()
    for counts in (1860, 1863) * (READINGS // 2):
        zero.receive(104, struct.pack("<3h", counts, counts, counts))
    assert zero.zeroed(PHYSICAL).current_zero_right == (1861.5, 1861.5, 1861.5)


def test_a_side_that_was_hardly_heard_keeps_its_zeros():
    zero = AutoZero()
    for _ in range(READINGS - 1):
        zero.receive(104, READ)
    assert zero.zeroed(PHYSICAL) == PHYSICAL


def test_other_frames_and_other_lengths_say_nothing_about_currents():
    zero = AutoZero()
    for _ in range(READINGS):
        zero.receive(106, READ)
        zero.receive(104, READ + b"!")
    assert zero.zeroed(PHYSICAL) == PHYSICAL
