"""Other devices' alerts in the boat's table: who moves whom, and what a flood cannot do."""

from collections import Counter
from collections.abc import Hashable

import msgspec
import pytest

from timonel.core.alerts import Alert, AlertChanged, AlertKind, Alerts, Priority
from timonel.core.effects import Event
from timonel.vehicles.boat.foreign_alerts import (
    CHANGES,
    FIRST,
    PLACES,
    PLACES_OF_ONE,
    SOURCES,
    TRIES,
    Answer,
    Condition,
    ForeignAlerts,
    Order,
    Report,
)

OURS = AlertKind(101, "backbone silent", Priority.ALARM)


def report(
    condition: Condition = Condition.ACTIVE,
    key: Hashable = "bilge",
    source: Hashable = 7,
    priority: Priority = Priority.ALARM,
    occurrence: int | None = 1,
    confirms: bool = True,
    text: str = "",
) -> Report:
    return Report(key, source, f"{key} said", condition, str(key), text, priority, 60.0, occurrence, confirms)


class Table:
    """The table, and what owners are told as it changes."""

    def __init__(self) -> None:
        self.counters: Counter[str] = Counter()
        self.alerts = Alerts()
        self.foreign = ForeignAlerts(self.alerts, self.counters)
        self.answers: list[Answer] = []

    def hear(self, told: Report, now: float = 0.0) -> list[Alert]:
        return self.tell(self.foreign.report(told, now), now)

    def tell(self, events: list[Event], now: float = 0.0) -> list[Alert]:
        changed = [event.alert for event in events if isinstance(event, AlertChanged)]
        for alert in changed:
            self.answers += self.foreign.changed(alert, now)
        return changed

    def acknowledge(self, number: int = FIRST, now: float = 0.0) -> list[Alert]:
        return self.tell(self.alerts.acknowledge(number), now)

    @property
    def states(self) -> list[tuple[int, bool, bool]]:
        return [(alert.kind.id, alert.active, alert.acknowledged) for alert in self.alerts.standing]


ACKNOWLEDGED = Answer(Order.ACKNOWLEDGE, "bilge said", 7)
SILENCED = Answer(Order.SILENCE, "bilge said", 7)


# What owners tell -----------------------------------------------------------------------------------


def test_an_alert_of_another_device_gets_a_number_and_keeps_it():
    table = Table()
    assert table.hear(report())[0].kind == AlertKind(FIRST, "bilge", Priority.ALARM)
    table.hear(report(key="engine"))
    table.hear(report(Condition.NORMAL))
    table.acknowledge()
    assert table.hear(report(occurrence=2))[0].kind.id == FIRST


@pytest.mark.parametrize(
    ("condition", "state"),
    [
        (Condition.ACTIVE, [(FIRST, True, False)]),
        (Condition.HOLDS, [(FIRST, True, False)]),
        (Condition.SILENCED, [(FIRST, True, False)]),
        (Condition.ACKNOWLEDGED, [(FIRST, True, True)]),
        (Condition.RECTIFIED, [(FIRST, False, False)]),
        (Condition.NORMAL, []),
    ],
)
def test_an_alert_first_heard_of_stands_as_its_owner_says(condition: Condition, state: list[tuple[int, bool, bool]]):
    table = Table()
    table.hear(report(condition))
    assert table.states == state
    assert table.answers == [], "who told it is not told it"
    assert (table.foreign.known("bilge") is None) == (condition is Condition.NORMAL)


@pytest.mark.parametrize(
    ("condition", "state"),
    [
        (Condition.SILENCED, [(FIRST, True, False)]),
        (Condition.ACKNOWLEDGED, [(FIRST, True, True)]),
        (Condition.RECTIFIED, [(FIRST, False, False)]),
        (Condition.NORMAL, [(FIRST, False, False)]),
    ],
)
def test_what_is_done_at_the_owner_is_done_here(condition: Condition, state: list[tuple[int, bool, bool]]):
    table = Table()
    table.hear(report())
    table.hear(report(condition), 1.0)
    assert table.states == state
    assert table.answers == []


def test_what_the_owner_silenced_is_silent_here_for_as_long_as_ever():
    table = Table()
    table.hear(report())
    assert table.hear(report(Condition.SILENCED), 5.0)[0].silenced_until == 35.0
    assert table.hear(report(Condition.SILENCED), 6.0) == []


def test_what_is_told_again_and_again_changes_nothing():
    table = Table()
    table.hear(report())
    assert all(table.hear(report(), float(second)) == [] for second in range(1, 100))


def test_an_owner_that_had_it_acknowledged_raises_it_anew():
    table = Table()
    table.hear(report(Condition.ACKNOWLEDGED))
    assert [alert.acknowledged for alert in table.hear(report(), 1.0)] == [True, False]
    assert table.states == [(FIRST, True, False)]
    assert table.answers == []


def test_another_occurrence_of_an_alert_is_a_new_one():
    table = Table()
    table.hear(report())
    table.acknowledge()
    table.answers.clear()
    table.hear(report(occurrence=2), 1.0)
    assert table.states == [(FIRST, True, False)]
    assert table.answers == []
    assert table.hear(report(occurrence=2), 2.0) == []


def test_that_an_alarm_holds_says_nothing_about_who_has_seen_it():
    table = Table()
    table.hear(report(confirms=False))
    table.acknowledge()
    assert table.hear(report(Condition.HOLDS, confirms=False), 1.0) == []
    assert table.states == [(FIRST, True, True)]
    table.hear(report(Condition.NORMAL, confirms=False), 2.0)
    table.hear(report(Condition.HOLDS, confirms=False), 3.0)
    assert table.states == [(FIRST, True, False)]


def test_an_alert_is_called_what_it_was_called_last():
    table = Table()
    table.hear(report())
    assert table.tell(table.foreign.reword("bilge", "high water", "aft", 1.0))[0].text == "aft"
    assert table.foreign.reword("bilge", "high water", "aft", 2.0) == []
    assert table.foreign.reword("engine", "hot", "", 2.0) == []
    worse = report(priority=Priority.EMERGENCY, text="fore")
    assert [alert.kind.priority for alert in table.hear(worse, 3.0)] == [Priority.EMERGENCY]


# What people do -------------------------------------------------------------------------------------


def test_an_acknowledgement_is_told_to_the_owner_until_it_shows_it():
    table = Table()
    table.hear(report())
    table.acknowledge()
    assert table.answers == [ACKNOWLEDGED]
    table.hear(report(), 1.0)
    assert table.foreign.deadline == 2.0
    assert table.foreign.expire(1.9) == ([], [])
    assert table.foreign.expire(2.0) == ([], [ACKNOWLEDGED])
    table.hear(report(Condition.ACKNOWLEDGED), 2.1)
    assert table.foreign.expire(4.0) == ([], [])


def test_an_owner_that_goes_on_as_before_is_told_three_times_and_no_more():
    table = Table()
    table.hear(report())
    table.acknowledge()
    told = [answer for now in range(1, 30) for answer in table.foreign.expire(float(now))[1]]
    assert len(told) == TRIES - 1
    assert table.counters == {"acknowledgements without effect": 1}
    assert table.hear(report(text="again"), 30.0)[0].acknowledged
    assert table.answers == [ACKNOWLEDGED], "words are no reason to begin again"


def test_an_owner_that_never_shows_anything_is_told_once():
    table = Table()
    table.hear(report(confirms=False))
    table.acknowledge()
    assert table.answers == [ACKNOWLEDGED]
    assert table.foreign.expire(50.0) == ([], [])
    assert table.hear(report(confirms=False), 51.0) == [], "it may be told it still holds, and stays acknowledged"


def test_silence_is_told_to_the_owner_once():
    table = Table()
    table.hear(report())
    table.tell(table.alerts.silence(FIRST, 1.0), 1.0)
    assert table.answers == [SILENCED]
    table.hear(report(text="more"), 2.0)
    assert table.answers == [SILENCED]
    table.tell(table.alerts.silence(FIRST, 3.0), 3.0)
    assert table.answers == [SILENCED, SILENCED], "30 s more"


def test_what_is_over_and_waits_for_acknowledgement_at_its_owner_gets_it_from_here():
    table = Table()
    table.hear(report(Condition.RECTIFIED))
    table.acknowledge()
    assert table.answers == [ACKNOWLEDGED]
    assert table.states == []


def test_what_is_over_at_its_owner_is_acknowledged_here_alone():
    table = Table()
    table.hear(report())
    table.hear(report(Condition.NORMAL))
    table.acknowledge()
    assert table.answers == []


def test_a_caution_is_acknowledged_to_nobody():
    table = Table()
    table.hear(report(priority=Priority.CAUTION))
    assert table.states == [(FIRST, True, True)]
    assert table.answers == []


def test_our_own_alerts_are_nobody_elses():
    table = Table()
    table.tell(table.alerts.arise(OURS, "", 0.0))
    table.acknowledge(101)
    assert table.answers == []
    assert table.foreign.entry(101) is None


# Silence of the owner -------------------------------------------------------------------------------


def test_an_alert_that_nobody_tells_any_more_is_over():
    table = Table()
    table.hear(report())
    table.hear(report(), 10.0)
    assert table.foreign.deadline == 70.0
    assert table.foreign.expire(69.9) == ([], [])
    assert table.tell(table.foreign.expire(70.0)[0])[0].active is False
    assert table.foreign.deadline == float("inf")
    table.hear(report(), 80.0)
    assert table.states == [(FIRST, True, False)], "its owner is back"


def test_nothing_is_due_where_there_is_nothing():
    assert Table().foreign.deadline == float("inf")


# Floods ---------------------------------------------------------------------------------------------


def flood(table: Table, sources: range, alerts: int, priority: Priority = Priority.WARNING) -> None:
    """Each source tells of so many alerts, as fast as it is heard."""
    for source in sources:
        for number in range(alerts):
            now = number // (CHANGES // 2) * 10.0
            told = report(key=(source, number), source=source, priority=priority)
            table.hear(msgspec.structs.replace(told, age=1e9), now)


def test_a_flood_of_one_source_leaves_room_for_others_and_for_ours():
    table = Table()
    table.tell(table.alerts.arise(OURS, "", 0.0))
    flood(table, range(1), 300)
    assert len(table.alerts.standing) == PLACES_OF_ONE + 1
    assert table.counters["alerts beyond the table"] == 300 - PLACES_OF_ONE
    assert table.hear(report(source=99))[0].kind.name == "bilge"


def test_a_flood_of_many_sources_does_not_grow_the_table():
    table = Table()
    table.tell(table.alerts.arise(OURS, "", 0.0))
    flood(table, range(20), 50)
    assert len(table.alerts.standing) == PLACES + 1
    assert table.alerts.active(OURS)
    assert table.hear(report(source=99)) != [], "what is more urgent takes the place of what is less so"
    assert len(table.alerts.standing) == PLACES + 1
    assert table.hear(report(key="leak", source=99, priority=Priority.WARNING)) == []


def test_the_place_of_what_is_over_is_given_away_first_and_nobody_acknowledges_by_that():
    table = Table()
    flood(table, range(4), PLACES_OF_ONE, Priority.ALARM)
    table.hear(report(Condition.NORMAL, key=(2, 5), source=2), 1000.0)
    table.acknowledge(table.foreign.known((2, 5)).number)  # type: ignore[union-attr]
    arisen = table.hear(report(source=99, priority=Priority.WARNING), 1000.0)
    assert [(alert.kind.name, alert.acknowledged) for alert in arisen] == [("bilge", False)]
    assert table.foreign.known((2, 5)) is None
    table.hear(report(key="fire", source=98, priority=Priority.EMERGENCY), 1000.0)
    assert table.foreign.known("bilge") is None, "the warning was the least urgent"
    assert table.answers == []


def test_a_source_whose_alerts_flap_is_heard_twenty_times_in_ten_seconds():
    table = Table()
    changes = 0
    for number in range(1000):
        condition = Condition.NORMAL if number % 2 else Condition.ACTIVE
        changes += len(table.hear(report(condition, occurrence=None), number / 1000.0))
    assert changes == CHANGES
    assert table.counters["alert changes beyond the allowance"] == (1000 - CHANGES) // 2, "every other one is as it was"
    assert table.states == [(FIRST, False, False)]
    table.hear(report(), 20.0)
    assert table.states == [(FIRST, True, False)], "it catches up with what is told over and over"


def test_a_source_with_many_new_alerts_at_once_is_heard_as_far_as_its_allowance_goes():
    table = Table()
    for number in range(30):
        table.hear(report(key=number))
    assert len(table.alerts.standing) == CHANGES
    table.hear(report(key=29), 10.0)
    assert len(table.alerts.standing) == CHANGES + 1


def test_names_that_change_all_the_time_are_bounded_too():
    table = Table()
    table.hear(report())
    changes = sum(len(table.foreign.reword("bilge", f"bilge {number}", "", 1.0)) for number in range(1000))
    assert changes == CHANGES - 1


def test_the_allowances_of_many_sources_are_bounded():
    table = Table()
    for source in range(10 * SOURCES):
        table.hear(report(key=source, source=source))
    assert len(table.foreign._allowances) == SOURCES
    assert len(table.foreign.entries) == PLACES
