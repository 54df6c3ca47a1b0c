"""The words of the console: the same keys in every language, each of them used, none missing."""

import json
import re
from pathlib import Path

import pytest

from timonel.core.alerts import AlertKind
from timonel.core.command import Denied, Overridden, Requested, Transferred
from timonel.core.effects import Effect
from timonel.gateway.health import describe
from timonel.vehicles.boat import alerts as boat
from timonel.vehicles.boat.pilot import DATA_AGE, FOLLOW_TIME, HEADING_LOST_TEXT, PILOT_AGE
from timonel.vehicles.rover import alerts as rover
from timonel.vehicles.rover.frames import BatteryState, DriverState
from timonel.vehicles.rover.watch import name_of

STATIC = Path(__file__).parents[3] / "src" / "timonel" / "web" / "static"
LANGUAGES = {path.stem: json.loads(path.read_text()) for path in (STATIC / "languages").glob("*.json")}
SCRIPTS = [path.read_text() for path in STATIC.rglob("*.js") if "vendor" not in path.parts]
LITERAL = re.compile(r"""["'`]([a-z_]+\.\w+)["'`]""")
MADE = re.compile(r"`([a-z_]+\.\w*)\$\{")  # t(`order.${verb}`), and what stands after the part that is put in
TRANSLATED = re.compile(r'translated\("(\w+)"')

FINE = (DriverState.RUNNING, DriverState.STOPPED)


def _named() -> set[str]:
    return {key for script in SCRIPTS for key in LITERAL.findall(script)}


def _begun() -> set[str]:
    made = {beginning for script in SCRIPTS for beginning in MADE.findall(script)}
    return made | {f"{prefix}." for script in SCRIPTS for prefix in TRANSLATED.findall(script)}


def test_there_are_english_spanish_and_polish() -> None:
    assert LANGUAGES.keys() == {"en", "es", "pl"}


@pytest.mark.parametrize("language", sorted(LANGUAGES.keys() - {"en"}))
def test_every_language_has_the_keys_of_english(language: str) -> None:
    assert sorted(LANGUAGES["en"].keys() - LANGUAGES[language].keys()) == []
    assert sorted(LANGUAGES[language].keys() - LANGUAGES["en"].keys()) == []


@pytest.mark.parametrize("language", sorted(LANGUAGES))
def test_what_is_put_into_a_text_is_the_same_in_every_language(language: str) -> None:
    for key, text in LANGUAGES[language].items():
        assert text.strip(), key
        assert set(re.findall(r"\{(\w+)\}", text)) == set(re.findall(r"\{(\w+)\}", LANGUAGES["en"][key])), key


def test_every_key_that_a_script_names_has_words() -> None:
    families = {key.split(".")[0] for key in LANGUAGES["en"]}
    named = {key for key in _named() if key.split(".")[0] in families and not key.endswith((".js", ".css", ".json"))}
    assert sorted(named - LANGUAGES["en"].keys() - {"timonel.language"}) == []


def test_every_key_is_used() -> None:
    named, begun = _named(), tuple(_begun())
    assert sorted(key for key in LANGUAGES["en"] if key not in named and not key.startswith(begun)) == []


def _shape(key: str) -> re.Pattern[str]:
    """What a key with places is looked up by, as `i18n.js` does it."""
    parts = re.split(r"\{(\w+)\}", key)
    places = ["(\\d+)" if name == "number" else "(.+?)" for name in parts[1::2]]
    return re.compile(
        "".join(part for pair in zip(map(re.escape, parts[::2]), [*places, ""], strict=True) for part in pair)
    )


def _has_words(prefix: str, text: str) -> bool:
    """Whether all of a text has words: what stands in its places too."""
    begin = f"{prefix}."
    keys = [key.removeprefix(begin) for key in LANGUAGES["en"] if key.startswith(begin)]
    if text in keys or text.isdecimal():
        return True
    matches = (_shape(key).fullmatch(text) for key in keys if "{" in key)
    return any(match is not None and all(_has_words(prefix, place) for place in match.groups()) for match in matches)


@pytest.mark.parametrize(
    "event",
    [Transferred(0, 1), Transferred(3, 0), Requested(2), Denied(4), Overridden((2,)), Overridden((2, 3, 4))],
    ids=describe,
)
def test_what_happens_to_command_has_words_in_every_language(event: Effect) -> None:
    assert _has_words("event", describe(event))


@pytest.mark.parametrize(
    "text",
    [
        f"nothing heard from the backbone for {DATA_AGE:g} s",
        HEADING_LOST_TEXT,
        f"the pilot has not reported for {PILOT_AGE:g} s",
        f"engage not followed for {FOLLOW_TIME:g} s",
        "station 2 gave up command and nobody took it while the pilot steers",
        "the port of station 1, which is in command, is unplugged",
        "station 1 was driving and has not been heard for 0.5 s",
        "told to turn for 2 s, but no wheel does, at 31 A",
        "a wheel turns at 12 rpm without permission",
        *(f"left motor driver: {name_of(state)}" for state in (*DriverState, None) if state not in FINE),
        *(f"battery: {name_of(state)}" for state in (*BatteryState, None) if state is not BatteryState.OK),
    ],
)
def test_what_an_alert_says_has_words_in_every_language(text: str) -> None:
    matches = [key for key in LANGUAGES["en"] if key.startswith("alert_text.")]
    assert any(_shape(key.removeprefix("alert_text.")).fullmatch(text) for key in matches), text


KINDS = [each for module in (boat, rover) for each in vars(module).values() if isinstance(each, AlertKind)]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_alert_has_a_name_in_every_language(kind: AlertKind) -> None:
    assert f"alert.{kind.name}" in LANGUAGES["en"]
