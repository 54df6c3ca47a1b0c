from pathlib import Path

from timonel.nmea0183.reference import page
from timonel.nmea0183.registry import SENTENCES

PAGE = Path(__file__).parents[3] / "docs" / "sentences.md"


def test_the_page_of_sentences_is_the_one_the_declarations_give() -> None:
    assert PAGE.read_text() == page()


def test_every_sentence_has_its_section() -> None:
    for formatter in SENTENCES:
        assert f"\n## {formatter.decode()}\n" in page()
