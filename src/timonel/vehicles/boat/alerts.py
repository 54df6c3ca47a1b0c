"""The alerts of a boat, with the numbers that ALR and ACK sentences carry."""

from timonel.core.alerts import AlertKind, Priority

BACKBONE_SILENT = AlertKind(101, "backbone silent", Priority.ALARM)
HEADING_LOST = AlertKind(102, "heading lost", Priority.ALARM)
PILOT_NOT_FOLLOWING = AlertKind(103, "pilot not following", Priority.WARNING)
PILOT_SILENT = AlertKind(104, "pilot silent", Priority.WARNING)
NO_COMMANDER = AlertKind(105, "steering without commander", Priority.WARNING)
COMMANDER_UNPLUGGED = AlertKind(106, "commander unplugged", Priority.WARNING)
NO_ADDRESS = AlertKind(107, "no address on the bus", Priority.ALARM)

NAVIGATIONAL = frozenset(kind.id for kind in (HEADING_LOST, NO_COMMANDER, COMMANDER_UNPLUGGED))
"""Those that are about the boat's way; the others are about what is broken."""
