"""Pilots that take NMEA 0183: HTC, HSC or APB, on the one output that the owner names.

sentence   holds a course by                    lets go by
HTC        steering mode H, heading to steer    steering mode M
HSC        the heading, true and magnetic       silence: nothing is sent, and the pilot's own head lets go
APB        a heading to steer on a track that   silence
           the boat never leaves

A course is said again every second while it is ours, by which the pilot sees that we are there. Most of these pilots
answer nothing; one that sends HTD on an instrument's input confirms by it. Source: NMEA 0183 HTC, HSC, APB.
"""

from collections.abc import Callable, Sequence
from math import degrees, radians

from timonel.core.effects import SayTo
from timonel.nmea0183 import sentences as s
from timonel.nmea0183.sentence import Sentence
from timonel.nmea2000.lookups import HeadingReference
from timonel.vehicles.boat.conversion import REFERENCES
from timonel.vehicles.boat.pilot import TURN, Manner
from timonel.vehicles.boat.pilots.driver import Answer, Compass, Driver, Evidence, Kind
from timonel.vehicles.boat.reports import Reading

KIND = Kind(
    name="sentence",
    steers="pilots that take HTC, HSC or APB over NMEA 0183",
    evidence=Evidence.STANDARD,
    sources="NMEA 0183",
    sends="HTC, HSC or APB on the output that pilot_output names",
    confirmed_by="HTD, if it sends any",
    absolute=True,
    references="true or magnetic, as the boat's; HSC both",
)
TALKER = "AG"


class SentencePilot(Driver):
    """See above. `words` are the formatters that it is told with, `output` the port."""

    on_bus = False

    def __init__(self, compass: Compass, words: Sequence[str], output: str) -> None:
        self._compass = compass
        self._words = words
        self._output = output

    def steer(self, setpoint: int | None, heading: float | None, now: float, manner: Manner) -> Sequence[Answer]:
        """See `Driver`."""
        answers: list[Answer] = []
        for word in self._words:
            sentence = WRITERS[word](self, setpoint, now)
            if sentence is not None:
                answers.append(SayTo(sentence.encode(TALKER), word, self._output))
        return answers

    def hear(self, reading: Reading, heading: float | None, now: float) -> float | None:
        """See `Driver`."""
        return self._compass.ours(reading.course, reading.reference, now)

    def htc(self, setpoint: int | None, now: float) -> Sentence:
        """Holds, or lets go."""
        if setpoint is None:
            return s.HTC(override=False, steering_mode=s.SteeringMode.MANUAL, turn_mode=s.TurnMode.NOT_CONTROLLED)
        return s.HTC(
            override=False,
            steering_mode=s.SteeringMode.HEADING_CONTROL,
            turn_mode=s.TurnMode.NOT_CONTROLLED,
            heading_to_steer_deg=setpoint / 10,
            reference=REFERENCES[self._compass.reference],
        )

    def hsc(self, setpoint: int | None, now: float) -> Sentence | None:
        """Holds; what cannot be known of both norths is left empty."""
        if setpoint is None:
            return None
        true, magnetic = (self._in(setpoint, north, now) for north in REFERENCES)
        return s.HSC(true, magnetic)

    def apb(self, setpoint: int | None, now: float) -> Sentence | None:
        """Holds: the leg is the course itself, and the boat is on it."""
        if setpoint is None:
            return None
        course, reference = setpoint / 10, REFERENCES[self._compass.reference]
        return s.APB(
            valid=True,
            locked=True,
            cross_track_error_nm=0.0,
            arrived=False,
            perpendicular_passed=False,
            leg_bearing_deg=course,
            leg_bearing_reference=reference,
            destination="COURSE",
            bearing_deg=course,
            bearing_reference=reference,
            heading_to_steer_deg=course,
            heading_to_steer_reference=reference,
            mode=s.Mode.AUTONOMOUS,  # of any other the pilot would have to take the whole for invalid
        )

    def _in(self, setpoint: int, north: HeadingReference, now: float) -> float | None:
        course = self._compass.theirs(radians(setpoint / 10), north, now)
        return None if course is None else round(degrees(course) * 10) % TURN / 10


WRITERS: dict[str, Callable[[SentencePilot, int | None, float], Sentence | None]] = {
    "HTC": SentencePilot.htc,
    "HSC": SentencePilot.hsc,
    "APB": SentencePilot.apb,
}
