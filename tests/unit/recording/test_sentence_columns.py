"""Values of sentences in columns, compiled and not: each is the parser's, bit for bit."""

import random

import pytest

from tests.unit.recording.sentences import compared, sealed
from timonel.nmea0183.registry import SENTENCES

pytestmark = pytest.mark.usefixtures("each_way")


def written(tmp_path, bodies):
    path = tmp_path / "log"
    path.write_bytes("".join(map(sealed, bodies)).encode("latin-1"))
    return path


def numbers() -> list[str]:
    draw = random.Random(12)
    found = [f"{draw.uniform(-10, 10) ** draw.randrange(1, 9):.{draw.randrange(12)}f}" for _ in range(3000)]
    found += ["".join(draw.choices("0123456789.-", k=draw.randrange(19))) for _ in range(1000)]
    found += ["".join(draw.choices("0123456789.-:/+ eA;", k=draw.randrange(12))) for _ in range(500)]
    plain = [f"{'7' * whole}.{'3' * places}" for whole in range(11) for places in range(11)]
    return found + plain + ["-" + number for number in plain] + [number.strip(".") for number in plain]


def test_numbers_of_all_shapes_are_those_of_the_parser(tmp_path):
    compared(written(tmp_path, [f"IIROT,{number},A" for number in numbers()]))
    compared(written(tmp_path, [f"IIHDG,{number},{number},E,{number},W" for number in numbers()]))


def test_positions_of_all_shapes_are_those_of_the_parser(tmp_path):
    draw = random.Random(13)
    minutes = [f"{draw.uniform(0, 61):0{draw.choice((5, 7, 9))}.{draw.randrange(9)}f}" for _ in range(3000)]
    latitudes = [f"{draw.randrange(91)}{minute},{draw.choice('NSNSNSNSE')}" for minute in minutes]
    longitudes = [f"{draw.randrange(181)}{minute},{draw.choice('EWEWEWEWN')}" for minute in minutes]
    edges = ["5959.99999999,N,17959.99999999", "9000,N,18000", "0,N,0", "100,S,100", "59.9999999,S,99.9", "60,N,60"]
    pairs = [*map(",".join, zip(latitudes, longitudes, strict=True)), *(f"{edge},W" for edge in edges)]
    compared(written(tmp_path, [f"GPGLL,{pair},120000,A,A" for pair in pairs]))


def test_times_of_all_shapes_are_those_of_the_parser(tmp_path):
    draw = random.Random(14)
    times = [f"{draw.randrange(25):02}{draw.randrange(61):02}{draw.randrange(62):02}" for _ in range(2000)]
    times += [f"{time}.{draw.randrange(10**places):0{places}}" for time in times for places in range(1, 3)]
    times += [f"235959.{'9' * places}" for places in range(12)] + ["-12000", "1200.5", "12000", "1200005", "120000x"]
    compared(written(tmp_path, [f"GPZDA,{time},01,02,2003,00,00" for time in times]))


def test_dates_of_every_year_are_those_of_the_parser(tmp_path):
    days = (0, 1, 15, 28, 29, 30, 31, 32)
    dates = [f"{day:02}{month:02}{year:02}" for year in range(100) for month in range(14) for day in days]
    compared(written(tmp_path, [f"GPRMC,,A,,,,,,,{date},,,A" for date in [*dates, "1", "01019", "0101900", "0a0101"]]))


def test_sentences_with_any_number_of_fields_are_those_of_the_parser(tmp_path):
    wires = ["1", "A", "", "12.5", "N", "x" * 20]
    bodies = [
        f"II{formatter.decode()}" + "".join("," + wires[(count + place) % 6] for place in range(count))
        for formatter in SENTENCES
        for count in range(40)
    ]
    compared(written(tmp_path, bodies))


def test_more_sentences_than_are_looked_at_together_keep_their_order(tmp_path):
    bodies = [f"II{('HDT', 'HDM', 'ROT')[number % 3]},{number % 360},{'TMA'[number % 3]}" for number in range(1000)]
    tables = compared(written(tmp_path, bodies))
    assert [table.line.tolist() for table in tables] == [list(range(first, 1001, 3)) for first in (1, 2, 3)]
