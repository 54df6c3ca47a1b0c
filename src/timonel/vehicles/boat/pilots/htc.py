"""HTC and HTD of NMEA 0183 as PGN 127237 of NMEA 2000, field by field, and back.

```
HTC / HTD                        127237
1     override A V               override yes, no
2, 3  rudder angle and L R       commanded rudder angle (starboard positive) and direction; 0 alone is "no order"
4     M S H T R                  steering mode: main, standalone, heading, track, follow-up
5     N T R                      turn mode: rudder limit, turn rate, radius
6, 7  limits in degrees          rudder limit, off-heading limit
8     radius in miles            radius of turn in m, with the sign of field 3
9     rate in degrees a minute   rate of turn
10    heading to steer           heading to steer         } one reference, field 13, for both
12    track                      track                    } and for the vessel's heading
11    off-track limit in miles   off-track limit in m
14-16 A V (HTD)                  limit exceeded: no, yes
17    heading (HTD)              vessel heading
```
Empty fields are not available. The way to HTD is `vehicles.boat.conversion.htd`. Lost on the
way: non-follow-up steering becomes R without an angle, which comes back as follow-up. Source: NMEA 0183 HTC, HTD.
"""

from math import radians, tau
from typing import Any

import msgspec

from timonel.nmea0183 import sentences as s
from timonel.nmea0183.sentences.steering import HeadingTrackControl as Shared
from timonel.nmea2000.lookups import DirectionRudder, HeadingReference, SteeringMode, YesNo
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.vehicles.boat.conversion import MILE, MINUTE, REFERENCES, STEERING_MODES, TURN_MODES, heading_track

MODES = {letter: mode for mode, letter in STEERING_MODES.items()} | {
    s.SteeringMode.RUDDER_CONTROL: SteeringMode.FOLLOW_UP,
}
TURNS = {letter: mode for mode, letter in TURN_MODES.items()}
NORTHS = {letter: reference for reference, letter in REFERENCES.items()}
SIDES = {s.RudderDirection.RIGHT: 1, s.RudderDirection.LEFT: -1, None: 1}
DIRECTIONS = {
    s.RudderDirection.RIGHT: DirectionRudder.STARBOARD,
    s.RudderDirection.LEFT: DirectionRudder.PORT,
}


WIDEST_TURN = 32764.0  # m, and the widest off-track limit
FASTEST_TURN = 3.125e-5 * 32764  # rad/s


def from_htc(sentence: s.HTC) -> HeadingTrackControl:
    """What an HTC commands, as 127237."""
    return HeadingTrackControl(**_shared(sentence))


def from_htd(sentence: s.HTD) -> HeadingTrackControl:
    """What an HTD reports, as 127237."""
    return HeadingTrackControl(
        **_shared(sentence),
        rudder_limit_exceeded=_exceeded(sentence.within_rudder_limit),
        off_heading_limit_exceeded=_exceeded(sentence.within_off_heading_limit),
        off_track_limit_exceeded=_exceeded(sentence.within_off_track_limit),
        vessel_heading=_rad(sentence.heading_deg),
    )


def to_htc(message: HeadingTrackControl) -> s.HTC:
    """What 127237 commands, as HTC: the fields that HTD has too."""
    told = heading_track(message)
    return s.HTC(**{name: getattr(told, name) for name in Shared.__struct_fields__})


class LetGo(msgspec.Struct, frozen=True):
    """An HTC that gives the rudder back."""


class Hold(msgspec.Struct, frozen=True):
    """An HTC that wants a heading held: `course` in rad of `reference`; None is the present one."""

    course: float | None
    reference: HeadingReference | None


Order = LetGo | Hold | str


def order(sentence: s.HTC) -> Order:
    """What a heading controller is to do with an HTC; why it does nothing, if it is a text."""
    if sentence.override:
        return "HTC: override in use"  # fields 4 and 5 are not to be looked at then
    match sentence.steering_mode:
        case s.SteeringMode.MANUAL:
            return LetGo()
        case s.SteeringMode.HEADING_CONTROL:
            message = from_htc(sentence)
            return Hold(message.heading_to_steer_course, message.heading_reference)
        case s.SteeringMode.STAND_ALONE:  # takes no heading from outside
            return Hold(None, None)
        case None:
            return "HTC: no steering mode"
    return f"HTC: steering mode {sentence.steering_mode} is not for us"


def _shared(sentence: Shared) -> dict[str, Any]:
    side = SIDES[sentence.rudder_direction]
    return {
        "override": None if sentence.override is None else YesNo(int(sentence.override)),
        "steering_mode": None if sentence.steering_mode is None else MODES[sentence.steering_mode],
        "turn_mode": None if sentence.turn_mode is None else TURNS[sentence.turn_mode],
        "heading_reference": None if sentence.reference is None else NORTHS[sentence.reference],
        "commanded_rudder_direction": _direction(sentence),
        "commanded_rudder_angle": None if (angle := sentence.rudder_angle_deg) is None else side * radians(angle),
        "heading_to_steer_course": _course(sentence.heading_to_steer_deg),
        "track": _course(sentence.track_deg),
        "rudder_limit": _rad(sentence.rudder_limit_deg),
        "off_heading_limit": _rad(sentence.off_heading_limit_deg),
        "radius_of_turn_order": None if (radius := _metres(sentence.radius_nm)) is None else side * radius,
        "rate_of_turn_order": _rate(sentence.rate_deg_min),
        "off_track_limit": _metres(sentence.off_track_limit_nm),
    }


def _direction(sentence: Shared) -> DirectionRudder | None:
    if sentence.rudder_direction is not None:
        return DIRECTIONS[sentence.rudder_direction]
    return DirectionRudder.NO_ORDER if sentence.rudder_angle_deg == 0 else None


def _rad(angle: float | None) -> float | None:
    return None if angle is None else radians(angle)


def _course(angle: float | None) -> float | None:
    return None if angle is None else radians(angle) % tau


def _metres(miles: float | None) -> int | None:
    """Whole metres; None where 127237 has no room for so many."""
    return None if miles is None or miles * MILE > WIDEST_TURN else round(miles * MILE)


def _rate(rate: float | None) -> float | None:
    """Of degrees a minute; None where 127237 has no room for so many."""
    turn = None if rate is None else radians(rate) / MINUTE
    return None if turn is None or abs(turn) > FASTEST_TURN else turn


def _exceeded(within: bool | None) -> YesNo | None:
    return None if within is None else YesNo(int(not within))
