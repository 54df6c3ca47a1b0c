"""What an owner may set about alerts: the `[alerts]` table of a configuration."""

from typing import Annotated, Literal

import msgspec

Wait = Annotated[float, msgspec.Meta(ge=0, le=3600)]


class AlertSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the alerts. A wait of 0 s is for ever."""

    foreign: bool = True
    """Whether other devices' alerts are in the table."""
    tell_bus: bool = True
    """Whether the bus is told of ours."""
    sentences: Literal["alr", "alf", "both"] = "alr"
    """What the stations are told in: ALF comes with the list ALC and the sign of life HBT."""
    alarm_repeat: Wait = 30.0
    """After how long an alarm that nobody acknowledges is announced again, s."""
    warning_repeat: Wait = 60.0
    """The same of a warning, s."""
    warning_escalation: Wait = 0.0
    """After how long a warning that nobody acknowledges becomes an alarm, s."""
