"""Both decoders of the catalogue, on payloads that nobody would send."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.catalogue import by_row, plain, table
from timonel.nmea2000 import catalogue
from timonel.nmea2000.catalogue_columns import select

DEFINITIONS = [definition for pgn in catalogue.pgns() for definition in catalogue.variants(pgn)]
TELLING = (0, 1, 2, 3, 5, 0x41, 0x7F, 0x80, 0xFD, 0xFE, 0xFF)


def payload_of(definition, random):
    """A payload of any length, random or full of telling values, with the constants of its definition."""
    size = random.choice((0, 1, 2, 3, 5, 8, 8, random.randrange(30), random.randrange(60), random.randrange(224)))
    draw = random.choice((lambda: random.randrange(256), lambda: random.choice(TELLING)))
    mask, value, end = definition.pattern
    bits = int.from_bytes(bytes(draw() for _ in range(size)), "little") & ~mask | value
    return bits.to_bytes(max(size, end, 1), "little")[:size]


@pytest.mark.usefixtures("each_way")
@pytest.mark.parametrize("seed", [1, 2])
def test_one_by_one_and_all_at_once_are_the_same_for_every_definition(seed):
    random = Random(seed)
    for definition in DEFINITIONS:
        payloads = [payload_of(definition, random) for _ in range(12)]
        rows = by_row(definition, payloads, filler=random.randrange(256))
        for payload, row in zip(payloads, rows, strict=True):
            assert row == plain(definition.decode_codes(payload)), (definition.id, payload.hex())


def test_no_payload_is_too_strange_for_json():
    random = Random(3)
    for definition in DEFINITIONS:
        for payload in (payload_of(definition, random) for _ in range(3)):
            definition.as_json(payload)
            definition.as_dict(payload, labels=False)


def test_rows_are_sorted_into_the_variants_that_find_finds():
    random = Random(4)
    for pgn in catalogue.pgns():
        payloads = [payload_of(definition, random) for definition in catalogue.variants(pgn) for _ in range(4)]
        found = select(pgn, *table(payloads, filler=0xFF))
        assert sorted(row for _, rows in found for row in rows) == list(range(len(payloads)))
        for definition, rows in found:
            assert all(catalogue.find(pgn, payloads[row]) is definition for row in rows)


@given(st.sampled_from(DEFINITIONS), st.binary(max_size=223))
def test_decoding_never_raises(definition, payload):
    assert by_row(definition, [payload]) == [plain(definition.decode_codes(payload))]


@given(st.integers(0, (1 << 18) - 1), st.binary(max_size=223))
def test_any_message_is_one_definition_or_none(pgn, payload):
    found = catalogue.find(pgn, payload)
    assert found is None or found in catalogue.candidates(pgn)
