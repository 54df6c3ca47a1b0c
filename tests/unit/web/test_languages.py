"""The words of the console: the same keys in every language, each of them used, none missing."""

import json
import re
from pathlib import Path

import pytest

STATIC = Path(__file__).parents[3] / "src" / "timonel" / "web" / "static"
LANGUAGES = {path.stem: json.loads(path.read_text()) for path in (STATIC / "languages").glob("*.json")}
SCRIPTS = [path.read_text() for path in STATIC.rglob("*.js") if "vendor" not in path.parts]
LITERAL = re.compile(r"""["'`]([a-z_]+\.\w+)["'`]""")
MADE = re.compile(r"`([a-z_]+\.\w*)\$\{")  # t(`order.${verb}`), and what stands after the part that is put in
TRANSLATED = re.compile(r'translated\("(\w+)"')


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
