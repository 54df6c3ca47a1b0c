"""The alerts of a rover."""

from timonel.core.alerts import AlertKind, Priority

LINK_LOST = AlertKind(201, "commander lost", Priority.ALARM)
STALLED = AlertKind(202, "wheels stalled", Priority.ALARM)
RUNAWAY = AlertKind(203, "wheels turn without permission", Priority.EMERGENCY)
DRIVER_RIGHT = AlertKind(204, "right motor driver", Priority.ALARM)
DRIVER_LEFT = AlertKind(205, "left motor driver", Priority.ALARM)
BATTERY = AlertKind(206, "battery", Priority.ALARM)
