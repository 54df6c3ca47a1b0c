"""Navico's (Simrad, B&G) messages of pilot and alarms. Nobody but their maker has documented them."""

from typing import Annotated

from timonel.core.fields import U8, U16, Ascii, Bits, Flags, Lookup, Match, Reserved, Spare
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    AlertState,
    AlertType,
    IndustryCode,
    ManufacturerCode,
    SimnetAlarmCommand,
    SimnetAlarmId,
    SimnetApEvent,
    SimnetApMode,
    SimnetApModeFlags,
    SimnetApStatus,
    SimnetAutopilotMode,
    SimnetAutopilotModeClass,
    SimnetDeviceModel,
    SimnetDeviceReport,
    SimnetDirection,
    SimnetEventType,
    SimnetNetworkGroup,
)


class Simnet(Message):
    """How every message of Simrad begins: `41 9f`."""

    manufacturer_code: Annotated[ManufacturerCode, Match(11)] = ManufacturerCode.SIMRAD
    reserved: Annotated[None, Reserved(2)] = None
    industry_code: Annotated[IndustryCode, Match(3)] = IndustryCode.MARINE


class SimnetDevice(Simnet):
    """How every report of PGN 65305 begins."""

    model: Annotated[SimnetDeviceModel | None, Lookup(8, SimnetDeviceModel)]


class SimnetDeviceStatus(SimnetDevice, pgn=65305):
    """PGN 65305: whether the pilot steers or the helmsman.

    Single frame, 1 Hz. Layout: canboat `simnetDeviceStatus`.
    """

    report: Annotated[SimnetDeviceReport, Match(8)] = SimnetDeviceReport.STATUS
    status: Annotated[SimnetApStatus | None, Lookup(8, SimnetApStatus)]
    spare7: Annotated[None, Spare(24)] = None


class SimnetDeviceStatusRequest(SimnetDevice, pgn=65305):
    """PGN 65305: the control head in command asks for the status.

    Single frame, 1 Hz. Layout: canboat `simnetDeviceStatusRequest`.
    """

    report: Annotated[SimnetDeviceReport, Match(8)] = SimnetDeviceReport.SEND_STATUS
    spare6: Annotated[None, Spare(32)] = None


class SimnetPilotMode(SimnetDevice, pgn=65305):
    """PGN 65305: the mode that the pilot is in.

    Single frame, 1 Hz. Layout: canboat `simnetPilotMode`.
    """

    report: Annotated[SimnetDeviceReport, Match(8)] = SimnetDeviceReport.MODE
    mode: Annotated[SimnetApModeFlags, Flags(16, SimnetApModeFlags)]
    spare7: Annotated[None, Spare(16)] = None


class SimnetDeviceModeRequest(SimnetDevice, pgn=65305):
    """PGN 65305: the control head in command asks for the mode.

    Single frame, 1 Hz. Layout: canboat `simnetDeviceModeRequest`.
    """

    report: Annotated[SimnetDeviceReport, Match(8)] = SimnetDeviceReport.SEND_MODE
    spare6: Annotated[None, Spare(32)] = None


class SimnetAutopilotModeState(Simnet, pgn=65340):
    """PGN 65340: the mode of an AC-42.

    Single frame, priority 3, 1 Hz. Layout: canboat `simnetAutopilotModeState`.
    """

    mode_class: Annotated[SimnetAutopilotModeClass | None, Lookup(8, SimnetAutopilotModeClass)]
    mode: Annotated[SimnetAutopilotMode | None, Lookup(8, SimnetAutopilotMode)]
    c: Annotated[int | None, U8()]
    d: Annotated[int | None, U8()]
    spare8: Annotated[None, Spare(8)] = None
    flags: Annotated[int | None, U8()]


class SimnetAutopilotAngle(Simnet, pgn=65341):
    """PGN 65341: mode and angle that the pilot steers to.

    Single frame, priority 6, on event. Layout: canboat `simnetAutopilotAngle`.
    """

    reserved4: Annotated[None, Reserved(16)] = None
    mode: Annotated[SimnetApMode | None, Lookup(8, SimnetApMode)]
    reserved6: Annotated[None, Reserved(8)] = None
    angle: Annotated[float | None, U16(1e-4, "rad")]


class SimnetAddressed(Simnet):
    """How a command and its reply begin; `address` is the pilot's address on the bus, None is any."""

    address: Annotated[int | None, U8()]
    reserved5: Annotated[None, Reserved(8)] = None
    network_group: Annotated[SimnetNetworkGroup | None, Lookup(8, SimnetNetworkGroup)] = None


class SimnetApCommand(SimnetAddressed, pgn=130850):
    """PGN 130850: a key of a control head was pressed.

    Fast packet, priority 2, on event. Layout: canboat `simnetApCommand`.
    """

    command_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.AP_COMMAND
    event: Annotated[SimnetApEvent | None, Lookup(8, SimnetApEvent)]
    spare9: Annotated[None, Spare(8)] = None  # a NAC-3 ignores a command that has 0xFF here
    reserved10: Annotated[None, Reserved(8)] = None
    reserved11: Annotated[None, Reserved(8)] = None
    reserved12: Annotated[None, Reserved(8)] = None
    reserved13: Annotated[None, Reserved(8)] = None


class SimnetCommandApTack(SimnetAddressed, pgn=130850):
    """PGN 130850: tack.

    Fast packet, priority 2, on event. Layout: canboat `simnetCommandApTack`.
    """

    command_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.AP_COMMAND
    event: Annotated[SimnetApEvent, Match(8)] = SimnetApEvent.TACK
    unknown_a: Annotated[int | None, U8()]
    unknown_b: Annotated[int | None, U8()]
    reserved11: Annotated[None, Reserved(24)] = None


class SimnetCommandApFollowUp(SimnetAddressed, pgn=130850):
    """PGN 130850: follow-up steering.

    Fast packet, priority 2, on event. Layout: canboat `simnetCommandApFollowUp`.
    """

    command_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.FOLLOW_UP
    event: Annotated[SimnetApEvent, Match(8)] = SimnetApEvent.FOLLOW_UP_MODE
    spare9: Annotated[None, Spare(8)] = None
    reserved10: Annotated[None, Reserved(32)] = None


class SimnetCommandApChangeCourse(SimnetAddressed, pgn=130850):
    """PGN 130850: change course by `angle` to `direction`, relative to the course now steered.

    Fast packet, priority 2, on event. Layout: canboat `simnetCommandApChangeCourse`.
    """

    command_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.AP_COMMAND
    event: Annotated[SimnetApEvent, Match(8)] = SimnetApEvent.CHANGE_COURSE
    spare9: Annotated[None, Spare(8)] = None  # a NAC-3 ignores a command that has 0xFF here
    direction: Annotated[SimnetDirection | None, Lookup(8, SimnetDirection)]
    angle: Annotated[float | None, U16(1e-4, "rad")]
    reserved12: Annotated[None, Reserved(8)] = None


class SimnetAlarm(SimnetAddressed, pgn=130850):
    """PGN 130850: an alarm is raised, acknowledged or silenced.

    Fast packet, priority 2, on event. Layout: canboat `simnetAlarm`.
    """

    event_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.ALARM
    command: Annotated[SimnetAlarmCommand | None, Lookup(8, SimnetAlarmCommand)]
    spare9: Annotated[None, Spare(8)] = None
    alarm_id: Annotated[SimnetAlarmId | None, Lookup(16, SimnetAlarmId)]
    f: Annotated[int | None, U8()]
    g: Annotated[int | None, U8()]


class SimnetApCommandReply(SimnetAddressed, pgn=130851):
    """PGN 130851: the pilot has understood a command; it says nothing about whether it obeys.

    Fast packet, priority 7, on event. Layout: canboat `simnetApCommandReply`.
    """

    command_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.AP_COMMAND
    event: Annotated[SimnetApEvent | None, Lookup(8, SimnetApEvent)]
    spare9: Annotated[None, Spare(8)] = None
    d: Annotated[int | None, U8()]
    value: Annotated[int | None, U16()]
    reserved12: Annotated[None, Reserved(8)] = None


class SimnetApCommandReplyChangeCourse(SimnetAddressed, pgn=130851):
    """PGN 130851: the pilot has understood a change of course.

    Fast packet, priority 7, on event. Layout: canboat `simnetApCommandReplyChangeCourse`.
    """

    command_type: Annotated[SimnetEventType, Match(8)] = SimnetEventType.AP_COMMAND
    event: Annotated[SimnetApEvent, Match(8)] = SimnetApEvent.CHANGE_COURSE
    spare9: Annotated[None, Spare(8)] = None
    direction: Annotated[SimnetDirection | None, Lookup(8, SimnetDirection)]
    angle: Annotated[float | None, U16(1e-4, "rad")]
    reserved12: Annotated[None, Reserved(8)] = None


class SimnetAlarmMessage(Simnet, pgn=130856):
    """PGN 130856: an alarm in words; 130850 tells the same in numbers.

    Fast packet, on event. Layout: canboat `simnetAlarmMessage`.
    """

    alarm_id: Annotated[SimnetAlarmId | None, Lookup(16, SimnetAlarmId)]
    b: Annotated[int | None, U8()]
    c: Annotated[int | None, U8()]
    text: Annotated[str | None, Ascii(223)]


class NavicoAlarm(Message, pgn=130825):
    """PGN 130825: an alarm that holds; it goes on telling `ACTIVE` after somebody has acknowledged it.

    Fast packet, priority 7, on event. Layout: canboat `navicoAlarm`.
    """

    manufacturer_code: Annotated[ManufacturerCode, Match(11)] = ManufacturerCode.NAVICO
    reserved: Annotated[None, Reserved(2)] = None
    industry_code: Annotated[IndustryCode, Match(3)] = IndustryCode.MARINE
    instance: Annotated[int | None, U8()]
    record_id: Annotated[int | None, U8()]
    alarm_type: Annotated[int | None, U16()]
    alarm_id: Annotated[SimnetAlarmId | None, Lookup(16, SimnetAlarmId)]
    alarm_state: Annotated[AlertState | None, Lookup(3, AlertState)]
    action_flag: Annotated[int, Bits(1)]
    alarm_severity: Annotated[AlertType | None, Lookup(4, AlertType)]
    value: Annotated[int | None, U16()]
