"""One table of the boat's alerts: ours, those of other devices, and everybody who looks at them.

Whatever moves the table, all are told: the stations by ALR (and ALF, if they want it), the bus by 126983 and 126985,
the alert's owner by what it understands (`alert_messages`). What is on the bus already is not put there again, and
what we said ourselves is not somebody else's alert when it comes back:

comes back as                                  known by
126983 from another gateway                    our NAME as its data source
ALR, ALF on an instrument's port               a text that stands in the table, under the number that we gave it or
                                               one that gateways give to others' alerts

What instruments on wires tell has no NAME, so the bus hears it as ours.
"""

from collections import Counter
from collections.abc import Callable, Hashable

import msgspec

from timonel.core.alerts import Alert, Alerts, Patience
from timonel.core.effects import Event, Say, SayTo
from timonel.core.message import Message
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences import ACK, ACN, ALC, ALF, ALR, ARC, AlertCommand
from timonel.nmea2000.devices import Devices
from timonel.nmea2000.lookups import AlertResponseCommand
from timonel.nmea2000.messages.alerts import Alert as AlertMessage
from timonel.nmea2000.messages.alerts import AlertResponse, AlertText
from timonel.nmea2000.messages.maretron import MaretronAlertTransmission
from timonel.nmea2000.messages.navico import NavicoAlarm, SimnetAlarm, SimnetAlarmMessage
from timonel.nmea2000.messages.raymarine import SeatalkAlarm
from timonel.vehicles.boat import alert_messages, alert_sentences
from timonel.vehicles.boat.alert_messages import NO_NAME, Words
from timonel.vehicles.boat.alert_sentences import MAKER, Instrument, Lists, Speaker
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.alert_teller import BusTeller
from timonel.vehicles.boat.foreign_alerts import FIRST, PLACES, Answer, Condition, ForeignAlerts, Report

HEARD: frozenset[type[Message]] = frozenset(
    (
        AlertMessage,
        AlertResponse,
        AlertText,
        MaretronAlertTransmission,
        NavicoAlarm,
        SeatalkAlarm,
        SimnetAlarm,
        SimnetAlarmMessage,
    )
)
COMMANDS = (b"ACK,", b"ACN,")
SENTENCES = (b"ALR,", b"ALF,", b"ALC,")
ALR_INTERVAL = 30.0  # s between two ALR of an alert that stands


class Done(msgspec.Struct):
    """What the table's change makes the boat do: events, messages to the bus, lines to the stations."""

    events: list[Event] = []
    messages: list[Message] = []
    lines: list[Say | SayTo] = []


class Alerting:
    """The table and its surroundings. `name` gives our own NAME; all ones while it is not known."""

    def __init__(
        self,
        settings: AlertSettings,
        alerts: Alerts,
        name: Callable[[], int],
        devices: Devices,
        counters: Counter[str],
        now: float,
    ) -> None:
        self._name = name
        self._settings = settings
        self._alerts = alerts
        self._devices = devices
        self._counters = counters
        self._foreign = ForeignAlerts(alerts, counters)
        self._words = Words()
        self._lists = Lists()
        self._teller = BusTeller(now)
        self._speaker = Speaker(now)
        self._times: dict[int, float | None] = {}
        self._alr_due = now + ALR_INTERVAL

    # In from the bus ------------------------------------------------------------------------------

    def hear(self, message: Message, source: int, now: float) -> list[Event]:
        """A message about alerts came in, one of `HEARD`."""
        match message:
            case AlertResponse():
                return self._responded(message, now)
            case AlertText():
                key = alert_messages.standard_key(message, source)
                name, text = message.alert_text_description, message.alert_location_text_description
                return self._named(key, now) if self._words.keep(key, name, text, message.language_id) else []
            case MaretronAlertTransmission():
                return self._state_in_words(message, source, now)
            case SimnetAlarmMessage():
                return self._simnet_words(message, now)
        report = self._read(message, source)
        return [] if report is None or not self._settings.foreign else self._foreign.report(report, now)

    def _read(self, message: Message, source: int) -> Report | None:
        match message:
            case AlertMessage():
                return None if self._is_ours(message) else self._owned(message, source)
            case SeatalkAlarm():
                return alert_messages.seatalk(message, source)
            case SimnetAlarm():
                return alert_messages.simnet(message, source, self._words)
            case NavicoAlarm():
                return alert_messages.navico(message, source, self._words)
        return None

    def _owned(self, message: AlertMessage, source: int) -> Report | None:
        report = alert_messages.standard(message, source, self._words)
        if report is None or report.text:
            return report
        name = message.data_source_network_id_name
        device = self._devices.by_name(name) or self._devices.at(source)
        model = None if device is None or device.product is None else device.product.model_id
        return msgspec.structs.replace(report, text=alert_messages.plain(model) or alert_messages.maker(name))

    def _is_ours(self, message: AlertMessage | AlertResponse) -> bool:
        """Whether it is about an alert that we tell the bus of: of our NAME, and while we have none of our number."""
        told = message.alert_id is not None and self._teller.occurrence(message.alert_id) is not None
        name = self._name()
        return message.data_source_network_id_name == name and (name != NO_NAME or told)

    def _named(self, key: Hashable, now: float) -> list[Event]:
        """An alert got words; if it is known it is called so from now on."""
        entry = self._foreign.known(key)
        if entry is None:
            return []
        words = self._words.of(key, entry.report.name)
        return self._foreign.reword(key, words.name, words.text or entry.report.text, now)

    def _state_in_words(self, message: MaretronAlertTransmission, source: int, now: float) -> list[Event]:
        """Maretron's words are those of the state, for alerts of which nobody says where they are."""
        key = alert_messages.standard_key(message, source)
        if self._words.of(key, "").text:
            return []
        text = alert_messages.maretron_words(message)
        return self._named(key, now) if self._words.keep(key, None, text) else []

    def _simnet_words(self, message: SimnetAlarmMessage, now: float) -> list[Event]:
        """Navico's alarms have the names of a table; their text says more."""
        key = alert_messages.simnet_key(message.alarm_id)
        entry = self._foreign.known(key)
        if not self._words.keep(key, message.text, None) or entry is None:
            return []
        return self._foreign.reword(key, entry.report.name, self._words.of(key, "").name, now)

    def _responded(self, message: AlertResponse, now: float) -> list[Event]:
        """Another device acknowledges or silences an alert of ours."""
        number = message.alert_id
        occurrence = None if number is None else self._teller.occurrence(number)
        if number is None or occurrence is None or not self._is_ours(message):
            return []
        if message.alert_occurrence_number not in (None, occurrence):
            self._counters["responses to an earlier alert"] += 1
            return []
        match message.response_command:
            case AlertResponseCommand.ACKNOWLEDGE:
                self._teller.acknowledged_by(number, message.acknowledge_source_network_id_name)
                return self._alerts.acknowledge(number)
            case AlertResponseCommand.TEMPORARY_SILENCE:
                return self._alerts.silence(number, now)
        self._counters["alert tests"] += 1
        return []

    # In from instruments and stations -------------------------------------------------------------

    def wants(self, sentence: bytes, instrument: bool) -> bool:
        """Whether a sentence is about alerts: a command, or an `instrument`'s telling of its own."""
        formatter = sentence[3:7]
        return formatter in COMMANDS or (instrument and formatter in SENTENCES)

    def instrument(self, sentence: Sentence, port: str, talker: str, now: float) -> list[Event]:
        """An instrument tells of its alerts, in one of `SENTENCES`."""
        if not self._settings.foreign:
            return []
        who = Instrument((port, talker))
        match sentence:
            case ALR(alarm=int() as number):
                ours = FIRST <= number < FIRST + PLACES
                return self._told(alert_sentences.alr(sentence, who), number, ours, now)
            case ALF(alarm=int() as number):
                return self._told(self._lists.alf(sentence, who), number, sentence.maker == MAKER, now)
            case ALC():
                return self._listed(sentence, who, now)
        return []

    def _told(self, report: Report | None, number: int, gateways: bool, now: float) -> list[Event]:
        if report is None or self._is_echo(report, number, gateways):
            return []
        return self._foreign.report(report, now)

    def _is_echo(self, report: Report, number: int, gateways: bool) -> bool:
        """Whether an instrument says again what the table has from elsewhere.

        `gateways` is whether the number is one that a gateway like us gives to others' alerts.
        """
        if self._foreign.known(report.key) is not None:
            return False
        said = alert_sentences.fitting(report.name, alert_sentences.ROOM["title"])
        for alert in self._alerts.standing:
            theirs = alert_sentences.fitting(alert.kind.name, alert_sentences.ROOM["title"])
            if said == theirs and (gateways or number == alert.kind.id):
                self._counters["alerts that came back"] += 1
                return True
        return False

    def _listed(self, sentence: ALC, who: Instrument, now: float) -> list[Event]:
        """A whole list: what it does not have any more is over."""
        listed = self._lists.alc(sentence, who)
        if listed is None:
            return []
        keys = {alert_sentences.key(who, entry.maker, entry.alarm, entry.instance) for entry in listed}
        events: list[Event] = []
        for entry in self._foreign.entries:
            if entry.report.source != who or not isinstance(entry.report.origin, ALF):
                continue
            gone = entry.report.key not in keys
            condition = Condition.NORMAL if gone else entry.condition
            events += self._foreign.report(msgspec.structs.replace(entry.report, condition=condition), now)
        return events

    def command(self, sentence: ACK | ACN, now: float, time: float | None) -> Done:
        """A station acknowledges, silences, takes over or asks about an alert. `time` is UTC, s of the day."""
        match sentence:
            case ACK(alarm=int() as number):
                return Done(events=self._alerts.acknowledge(number))
            case ACN(alarm=int() as number, maker=None | alert_sentences.MAKER):
                return self._commanded(sentence, number, now, time)
            case ACN():
                return Done(lines=[_refused(sentence, time)])
        return Done()

    def _commanded(self, sentence: ACN, number: int, now: float, time: float | None) -> Done:
        alert = self._alerts.get(number)
        if alert is None:
            return Done(lines=[_refused(sentence, time)])
        match sentence.command:
            case AlertCommand.ACKNOWLEDGE:
                events = self._alerts.acknowledge(number)
            case AlertCommand.SILENCE:
                events = self._alerts.silence(number, now)
            case AlertCommand.TAKE_RESPONSIBILITY:
                events = self._alerts.transfer(number)
            case _:
                return Done(lines=self._lines(alert, self._speaker.again))
        return Done(events=events) if events else Done(lines=[_refused(sentence, time)])

    # Out ------------------------------------------------------------------------------------------

    def changed(self, alert: Alert, now: float, time: float | None) -> Done:
        """The table has changed: everybody hears it. `time` is UTC, s of the day; None if it is not known."""
        number = alert.kind.id
        self._times[number] = time
        done = Done(lines=self._lines(alert, self._speaker.changed))
        answers = self._foreign.changed(alert, now)
        if self._settings.tell_bus and self._is_told_by_us(number):
            done.messages += self._teller.changed(alert, self._name(), now)
        else:
            self._teller.forget(number)
        self._answer(answers, done)
        if not alert.active and alert.acknowledged:
            del self._times[number]
        return done

    def _is_told_by_us(self, number: int) -> bool:
        """Whether the bus would not hear of it without us."""
        entry = self._foreign.entry(number)
        if entry is None:
            return number < FIRST or self._teller.occurrence(number) is not None
        return isinstance(entry.report.origin, Sentence)

    def _answer(self, answers: list[Answer], done: Done) -> None:
        for answer in answers:
            message = alert_messages.answer(answer.order, answer.origin, self._name())
            if message is not None:
                done.messages.append(message)
            if isinstance(answer.source, Instrument):
                done.lines += alert_sentences.answer(answer.order, answer.origin, answer.source)

    def _lines(self, alert: Alert, alf: Callable[[Alert, float | None], list[Say]]) -> list[Say | SayTo]:
        """An alert as it stands, in the sentences that are wanted; `alf` says it in ALF."""
        lines: list[Say | SayTo] = []
        if self._settings.sentences != "alf":
            lines.append(self._alr(alert))
        if self._settings.sentences != "alr":
            lines += alf(alert, self._times.get(alert.kind.id))
        return lines

    def restate(self) -> list[Say | SayTo]:
        """All that stands, for a port that has just come."""
        return [line for alert in self._alerts.standing for line in self._lines(alert, self._speaker.again)]

    # Time -----------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float:
        """When `expire` is due, s."""
        lists = self._speaker.deadline if self._settings.sentences != "alr" else float("inf")
        return min(self._foreign.deadline, self._teller.deadline, self._alr_due, lists)

    def expire(self, now: float) -> Done:
        """What the passing of time brings about."""
        events, answers = self._foreign.expire(now)
        done = Done(events=events, messages=self._teller.expire(self._name(), now))
        self._answer(answers, done)
        if now >= self._alr_due:
            self._alr_due = now + ALR_INTERVAL
            if self._settings.sentences != "alf":
                done.lines += [self._alr(alert) for alert in self._alerts.standing]
        if self._settings.sentences != "alr":
            done.lines += self._speaker.expire(self._alerts.standing, now)
        return done

    def _alr(self, alert: Alert) -> Say:
        return Say(alert_sentences.said_alr(alert, self._times.get(alert.kind.id)), "ALR", urgent=True)


def _refused(command: ACN, time: float | None) -> Say:
    refused = ARC(time, command.maker, command.alarm, command.instance, command.command)
    return Say(refused.encode(), "ARC", urgent=True)


def patience(settings: AlertSettings) -> Patience:
    """How long the table waits for an acknowledgement; 0 in the settings is for ever."""
    return Patience(settings.alarm_repeat or None, settings.warning_repeat or None, settings.warning_escalation or None)
