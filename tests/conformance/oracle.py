"""What a sentence must print, computed from values that the PyPI package `nmea2000` decodes.

It knows nothing of how the boat chooses between sources: where a sentence has values of earlier messages, any
that was told within the age limit will do. What is of the very message that brought the sentence about must be
that value and no other. An expectation of a field is None (empty), a text, or a `Near`.
"""

from collections import defaultdict, deque
from datetime import date, timedelta
from math import degrees

import msgspec
from nmea2000 import backend

KNOT, MILE, FOOT, FATHOM = 1852 / 3600, 1852.0, 0.3048, 1.8288
AGE = 3.0  # s, spec/boat.md
CLOCK_AGE = 2.0  # s
CHANGE = 2.0  # s in which the boat may still wait for a source that has gone silent
MODES = {0: "N", 1: "A", 2: "D", 3: "P", 4: "R", 5: "F", 6: "E", 7: "M", 8: "S"}
XTE_MODES = {0: "A", 1: "D", 2: "E", 3: "S", 4: "M", 15: "A"}
STEERING = {0: "M", 1: "R", 2: "R", 3: "S", 4: "H", 5: "T"}
TURNS = {0: "N", 1: "T", 2: "R"}
REFERENCES = {0: "T", 1: "M"}
TRUE, MAGNETIC = 0, 1
LOOKUPS = {  # fields of which the number on the wire is wanted, not the words
    "reference", "cogReference", "headingReference", "courseBearingReference", "method", "xteMode", "steeringMode",
    "turnMode", "commandedRudderDirection", "navigationTerminated", "perpendicularCrossed", "arrivalCircleEntered",
    "override", "rudderLimitExceeded", "offHeadingLimitExceeded", "offTrackLimitExceeded", "date", "time",
    "temperatureSource", "source", "setReference",
}  # fmt: skip


class Near(msgspec.Struct, frozen=True):
    """A number printed with `decimals`; `turn` says that 360 is 0."""

    value: float
    decimals: int = 1
    turn: bool = False

    def accepts(self, text):
        whole, _, fraction = text.partition(".")
        if len(fraction) != self.decimals or not whole.lstrip("-").isdigit() or (float(text) == 0 and "-" in text):
            return False
        difference = abs(float(text) - self.value)
        if self.turn:
            difference = min(difference % 360, -difference % 360)
        half = 0.5 * 10**-self.decimals
        return difference <= half * (1 + 1e-6) + abs(self.value) * 1e-12 and not (self.turn and float(text) >= 360)


def accepts(expected, text):
    match expected:
        case Near():
            return expected.accepts(text)
        case None:
            return text == ""
    return text == expected


def matches(wanted, head):
    return len(wanted) == len(head) and all(map(accepts, wanted, head))


# From values to fields; None goes through ---------------------------------------------------------


def near(value, decimals=1, factor=1.0):
    return None if value is None else Near(value * factor, decimals)


def angle(radians):
    return None if radians is None else Near(degrees(radians))


def bearing(radians):
    return None if radians is None else Near(degrees(radians) % 360, turn=True)


def signed(value, positive, negative, decimals=1):
    """A magnitude and its letter; what rounds to zero is positive."""
    if value is None:
        return None, None
    zero = abs(value) <= 0.5 * 10**-decimals
    return Near(abs(value), decimals), negative if value < 0 and not zero else positive


def east(radians):
    return signed(None if radians is None else degrees(radians), "E", "W")


def coordinate(value, digits, positive, negative):
    """`ddmm.mmmmmm` as a number, and the hemisphere."""
    whole, rest = divmod(abs(value), 1)
    hemisphere = negative if round(value * 60e6) < 0 else positive
    return Near(whole * 100 + rest * 60, 6), hemisphere


def position(latitude, longitude):
    return (*coordinate(latitude, 2, "N", "S"), *coordinate(longitude, 3, "E", "W"))


def clock(seconds):
    """The texts that a time of day may have: a hundredth that is a tie goes either way."""
    hundredths = {min(int(seconds * 100 + shift), 8639999) for shift in (0.4999, 0.5001)}
    return {
        f"{h // 360000:02d}{h // 6000 % 60:02d}{h // 100 % 60:02d}" + (f".{h % 100:02d}" if h % 100 else "")
        for h in hundredths
    }


def yes(code):
    return {0: "V", 1: "A"}.get(code)


def within(code):
    return {0: "A", 1: "V"}.get(code)


class Oracle:
    """Remembers what was told, and says which fields a sentence may have."""

    def __init__(self):
        self.told = defaultdict(deque)
        self.names = {}

    def hear(self, pgn, source, payload, now):
        """The values of a message, kept for the sentences that need earlier ones; None if it has none."""
        message = backend.decode(pgn, payload, source, units="si")
        if message is None:
            return None
        values = {f.id: f.raw_value if f.id in LOOKUPS else f.value for f in message.fields}
        remember = getattr(self, f"remember_{pgn}", None)
        if remember:
            remember(values, now)
        return values

    def remember(self, kind, value, now):
        told = self.told[kind]
        told.append((now, value))
        while told[0][0] <= now - AGE:
            told.popleft()

    def recent(self, kind, now, age=AGE):
        """What was told within `age`; and None if that may be too old or was taken back."""
        told = [(t, value) for t, value in self.told[kind] if now - t < age]
        values = list(dict.fromkeys(value for _, value in told if value is not None))
        sure = any(now - t < min(age, AGE - CHANGE) for t, value in told if value is not None)
        return values if sure and all(value is not None for _, value in told) else [*values, None]

    # What is remembered ---------------------------------------------------------------------------

    def remember_127250(self, values, now):
        if values["variation"] is not None:
            self.remember("variation", values["variation"], now)
        for true in self.true_headings(values, now):
            self.remember("true", true, now)
        for magnetic in self.magnetic_headings(values, now):
            self.remember("magnetic", magnetic, now)

    def remember_127258(self, values, now):
        if values["variation"] is not None:
            self.remember("variation", values["variation"], now)

    def remember_129025(self, values, now):
        place = values["latitude"], values["longitude"]
        self.remember("position", None if None in place else place, now)

    def remember_129029(self, values, now):
        self.remember_129025(values, now)
        self.remember_126992(values, now)
        self.remember("method", values["method"], now)

    def remember_126992(self, values, now):
        if values["date"] is not None and values["time"] is not None and values["date"] >= 10957:
            self.remember("clock", (values["date"], values["time"]), now)

    remember_129033 = remember_126992

    def remember_129283(self, values, now):
        self.remember("leg", (values["xte"], values["navigationTerminated"], values["xteMode"]), now)

    def remember_129285(self, values, now):
        for waypoint in values.get("##list##") or ():
            self.names[waypoint["wpId"].value] = waypoint["wpName"].value

    # What is computed -----------------------------------------------------------------------------

    def variations(self, values, now):
        """Of a heading: its own variation, or any that was told."""
        own = values["variation"]
        return self.recent("variation", now) if own is None else [own]

    def true_headings(self, values, now):
        heading = values["heading"]
        if heading is None or values["reference"] == TRUE:
            return [heading] * (heading is not None)
        if values["reference"] != MAGNETIC:
            return []
        magnetic = heading + (values["deviation"] or 0.0)
        return [magnetic + variation for variation in self.variations(values, now) if variation is not None]

    def magnetic_headings(self, values, now):
        heading = values["heading"]
        if heading is None or values["reference"] not in (TRUE, MAGNETIC):
            return []
        if values["reference"] == MAGNETIC:
            return [heading + (values["deviation"] or 0.0)]
        return [heading - variation for variation in self.variations(values, now) if variation is not None]

    def converted(self, radians, reference, wanted, now):
        """A direction in the reference `wanted`: as it is, or by any variation."""
        if radians is None or reference not in (TRUE, MAGNETIC):
            return [None]
        if reference == wanted:
            return [bearing(radians)]
        sign = 1 if wanted == TRUE else -1
        return [None if v is None else bearing(radians + sign * v) for v in self.recent("variation", now)]

    def modes(self, now):
        """Mode letters; A where nobody tells how positions are found."""
        return [MODES.get(method, "A") for method in self.recent("method", now)]

    def positions(self, now):
        return [(None,) * 4 if p is None else position(*p) for p in self.recent("position", now)]

    def times(self, now):
        told = self.recent("clock", now, CLOCK_AGE)
        return [None if c is None else text for c in told for text in (clock(c[1]) if c else (None,))]

    # Sentences: groups of fields, each with the alternatives it may have ----------------------------

    def expected_hdt(self, values, now):
        return [[(bearing(heading), "T") for heading in self.true_headings(values, now)]]

    def expected_ths(self, values, now):
        return [[(bearing(heading), "A") for heading in self.true_headings(values, now)]]

    def expected_hdm(self, values, now):
        return [[(bearing(heading), "M") for heading in self.magnetic_headings(values, now)]]

    def expected_hdg(self, values, now):
        variations = [east(variation) for variation in self.variations(values, now)]
        if values["reference"] == MAGNETIC:
            return [[(bearing(values["heading"]), *east(values["deviation"]))], variations]
        return [[(bearing(h), None, None) for h in self.magnetic_headings(values, now)], variations]

    def expected_rot(self, values, now):
        return [[(near(values["rate"], factor=degrees(60)), "A")]]

    def expected_rsa(self, values, now):
        return [[(angle(values["position"]), "A", None, None)]]

    def expected_vhw(self, values, now):
        speed = values["speedWaterReferenced"]
        true = [(bearing(h), None if h is None else "T") for h in self.recent("true", now)]
        magnetic = [(bearing(h), None if h is None else "M") for h in self.recent("magnetic", now)]
        return [true, magnetic, [(near(speed, factor=1 / KNOT), "N", near(speed, factor=3.6), "K")]]

    def expected_vlw(self, values, now):
        return [[(near(values["log"], 2, 1 / MILE), "N", near(values["tripLog"], 2, 1 / MILE), "N")]]

    def expected_dpt(self, values, now):
        told = near(values["depth"]), near(values["offset"]), near(values["range"])
        return [[told if told[2] else told[:2]]]

    def expected_dbt(self, values, now):
        depth = values["depth"]
        return [[(near(depth, factor=1 / FOOT), "f", near(depth), "M", near(depth, factor=1 / FATHOM), "F")]]

    def expected_vdr(self, values, now):
        current, reference = values["set"], values["setReference"]
        return [
            [(c, "T") for c in self.converted(current, reference, TRUE, now)],
            [(c, "M") for c in self.converted(current, reference, MAGNETIC, now)],
            [(near(values["drift"], factor=1 / KNOT), "N")],
        ]

    def expected_mtw(self, values, now):
        for name in ("temperature", "actualTemperature", "waterTemperature"):
            if values.get(name) is not None:
                place = values.get("temperatureSource", values.get("source", 0))
                return [[(Near(values[name] - 273.15), "C")] if place == 0 else []]
        return [[]]

    def expected_gll(self, values, now):
        statuses = [("A" if mode in "ADPRF" else "V", mode) for mode in self.modes(now)]
        return [self.positions(now), [(time,) for time in self.times(now)], statuses]

    def expected_rmc(self, values, now):
        dates = [None] if None in self.times(now) else []
        days = [c[0] for c in self.recent("clock", now, CLOCK_AGE) if c]
        dates += [f"{day:%d%m%y}" for day in map(date_of, days)]
        modes = self.modes(now) + (["N"] if (None,) * 4 in self.positions(now) else [])
        return [
            [(time,) for time in self.times(now)],
            [("A",), ("V",)],
            self.positions(now),
            [(near(values["sog"], factor=1 / KNOT),)],
            [(course,) for course in self.converted(values["cog"], values["cogReference"], TRUE, now)],
            [(text,) for text in dates],
            [east(variation) for variation in self.recent("variation", now)],
            [(mode,) for mode in modes],
        ]

    def expected_vtg(self, values, now):
        course, reference, speed = values["cog"], values["cogReference"], values["sog"]
        return [
            [(c, "T") for c in self.converted(course, reference, TRUE, now)],
            [(c, "M") for c in self.converted(course, reference, MAGNETIC, now)],
            [(near(speed, factor=1 / KNOT), "N", near(speed, factor=3.6), "K")],
            [(mode,) for mode in self.modes(now)],
        ]

    def expected_gga(self, values, now):
        satellites = values["numberOfSvs"]
        return [
            [(text,) for text in (clock(values["time"]) if values["time"] is not None else (None,))],
            [position(values["latitude"], values["longitude"])],
            [(str(values["method"] if values["method"] in MODES else 0),)],
            [(None if satellites is None else f"{min(satellites, 99):02d}", near(values["hdop"]))],
            [(near(values["altitude"]), "M", near(values["geoidalSeparation"]), "M", None, None)],
        ]

    def expected_zda(self, values, now):
        told = [c for c in self.recent("clock", now, CLOCK_AGE) if c]
        return [
            [
                (t, f"{d:%d}", f"{d:%m}", f"{d:%Y}", None, None)
                for day, s in told
                for t in clock(s)
                for d in [date_of(day)]
            ]
        ]

    def expected_mwv(self, values, now):
        letter = {2: "R", 3: "T", 4: "T"}.get(values["reference"], "-")
        return [[(bearing(values["windAngle"]), letter, near(values["windSpeed"], factor=1 / KNOT), "N", "A")]]

    def expected_mwd(self, values, now):
        wind, reference, speed = values["windAngle"], values["reference"], values["windSpeed"]
        return [
            [(d, "T") for d in self.converted(wind, reference, TRUE, now)],
            [(d, "M") for d in self.converted(wind, reference, MAGNETIC, now)],
            [(near(speed, factor=1 / KNOT), "N", near(speed), "M")],
        ]

    def expected_xte(self, values, now):
        valid = "V" if values["navigationTerminated"] == 1 else "A"
        mode = XTE_MODES.get(values["xteMode"], "N")
        first = valid if mode in "AD" else "V"
        return [[(first, valid, *signed(values["xte"] / MILE, "L", "R", 3), "N", mode)]]

    def expected_htd(self, values, now):
        rudder, radius, limit = values["commandedRudderAngle"], values["radiusOfTurnOrder"], values["offTrackLimit"]
        by_sign = {True: "R", False: "L"}[rudder > 0] if rudder else None
        return [
            [
                (
                    yes(values["override"]),
                    angle(None if rudder is None else abs(rudder)),
                    {1: "R", 2: "L"}.get(values["commandedRudderDirection"], by_sign),
                    STEERING.get(values["steeringMode"]),
                    TURNS.get(values["turnMode"]),
                    angle(values["rudderLimit"]),
                    angle(values["offHeadingLimit"]),
                    near(None if radius is None else abs(radius), 2, 1 / MILE),
                    near(values["rateOfTurnOrder"], factor=degrees(60)),
                    bearing(values["headingToSteerCourse"]),
                    near(None if limit is None else abs(limit), 2, 1 / MILE),
                    bearing(values["track"]),
                    REFERENCES.get(values["headingReference"]),
                    within(values["rudderLimitExceeded"]),
                    within(values["offHeadingLimitExceeded"]),
                    within(values["offTrackLimitExceeded"]),
                    bearing(values["vesselHeading"]),
                )
            ]
        ]

    def expected_xdr(self, values, now):
        told = [("PITCH", values["pitch"]), ("ROLL", values["roll"])]
        return [[("A", trimmed(degrees(value)), "D", name)] for name, value in told if value is not None]

    def waypoint(self, number):
        return None if number is None else self.names.get(number) or str(number)

    def expected_rmb(self, values, now):
        bearings = self.converted(
            values["bearingPositionToDestinationWaypoint"], values["courseBearingReference"], TRUE, now
        )
        place = values["destinationLatitude"], values["destinationLongitude"]
        origin, destination = (self.waypoint(values[f"{end}WaypointNumber"]) for end in ("origin", "destination"))
        legs = [leg for leg in self.recent("leg", now) if leg]
        return [
            [(valid_leg(leg, mode=True), *cross_track(leg, 2, 9.99)) for leg in legs],
            [(origin, destination)],
            [(None,) * 4 if None in place else position(*place)],
            [(limited(near(values["distanceToWaypoint"], factor=1 / MILE), 999.9),)],
            [(b,) for b in bearings],
            [(near(values["waypointClosingVelocity"], factor=1 / KNOT),)],
            [(arrival(values),)],
            [(XTE_MODES.get(leg[2], "N"),) for leg in legs],
        ]

    def expected_apb(self, values, now):
        reference = REFERENCES.get(values["courseBearingReference"])
        to = bearing(values["bearingPositionToDestinationWaypoint"])
        legs = [leg for leg in self.recent("leg", now) if leg]
        return [
            [(valid_leg(leg, mode=True), valid_leg(leg), *cross_track(leg, 3), "N") for leg in legs],
            [(yes(values["arrivalCircleEntered"]), yes(values["perpendicularCrossed"]))],
            [(bearing(values["bearingOriginToDestinationWaypoint"]), reference)],
            [(self.waypoint(values["destinationWaypointNumber"]),)],
            [(to, reference, to, reference)],
            [(XTE_MODES.get(leg[2], "N"),) for leg in legs],
        ]

    def mistakes(self, sentence, values, now):
        """What is wrong with the fields of a sentence that a message with `values` brought about."""
        formatter, *fields = sentence.split(",")
        groups = getattr(self, f"expected_{formatter[-3:].lower()}")(values, now)
        for alternatives in groups:
            size = len(alternatives[0]) if alternatives else 0
            head, fields = fields[:size], fields[size:]
            if not any(matches(wanted, head) for wanted in alternatives):
                return f"{sentence}: {head} is none of {alternatives}"
        return f"{sentence}: {fields} are too many" if fields else None


def date_of(days):
    return date(1970, 1, 1) + timedelta(days=days)


def trimmed(value):
    """A number with one decimal at most, as XDR has it."""
    return f"{round(value, 1):z.1f}".removesuffix(".0")


def valid_leg(leg, mode=False):
    trusted = not mode or XTE_MODES.get(leg[2], "N") in "AD"
    return "A" if leg[0] is not None and leg[1] != 1 and trusted else "V"


def cross_track(leg, decimals, ceiling=1e9):
    magnitude, letter = signed(None if leg[0] is None else leg[0] / MILE, "L", "R", decimals)
    return limited(magnitude, ceiling), letter


def limited(number, ceiling):
    return Near(ceiling, number.decimals) if number is not None and number.value > ceiling else number


def arrival(values):
    circle, abeam = yes(values["arrivalCircleEntered"]), yes(values["perpendicularCrossed"])
    return circle if circle == "A" else abeam or circle
