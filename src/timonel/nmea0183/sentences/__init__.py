"""The typed sentences, each declared once."""

from timonel.nmea0183.fields import Mode
from timonel.nmea0183.sentences.alarm import (
    ACK,
    ACN,
    ALC,
    ALF,
    ALR,
    ARC,
    HBT,
    AlertCategory,
    AlertCommand,
    AlertCondition,
    AlertUrgency,
    Listed,
)
from timonel.nmea0183.sentences.heading import HDG, HDM, HDT, HSC, ROT, THS, HeadingMode
from timonel.nmea0183.sentences.kinds import Reference
from timonel.nmea0183.sentences.position import GGA, GLL, RMC, VTG, ZDA, NavigationalStatus
from timonel.nmea0183.sentences.route import APB, RMB, XTE
from timonel.nmea0183.sentences.steering import HTC, HTD, RSA, RudderDirection, SteeringMode, TurnMode
from timonel.nmea0183.sentences.transducer import XDR, Transducer
from timonel.nmea0183.sentences.water import DBK, DBS, DBT, DPT, MTW, VDR, VHW, VLW
from timonel.nmea0183.sentences.wind import MWD, MWV, SpeedUnit, WindReference

__all__ = [
    "ACK",
    "ACN",
    "ALC",
    "ALF",
    "ALR",
    "APB",
    "ARC",
    "DBK",
    "DBS",
    "DBT",
    "DPT",
    "GGA",
    "GLL",
    "HBT",
    "HDG",
    "HDM",
    "HDT",
    "HSC",
    "HTC",
    "HTD",
    "MTW",
    "MWD",
    "MWV",
    "RMB",
    "RMC",
    "ROT",
    "RSA",
    "THS",
    "VDR",
    "VHW",
    "VLW",
    "VTG",
    "XDR",
    "XTE",
    "ZDA",
    "AlertCategory",
    "AlertCommand",
    "AlertCondition",
    "AlertUrgency",
    "HeadingMode",
    "Listed",
    "Mode",
    "NavigationalStatus",
    "Reference",
    "RudderDirection",
    "SpeedUnit",
    "SteeringMode",
    "Transducer",
    "TurnMode",
    "WindReference",
]
