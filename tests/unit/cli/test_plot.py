"""`timonel plot` and `timonel track`: pages that have their data in them and need nothing else."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest

import timonel as library
from tests.recordings import recording
from tests.unit.cli.programs import timonel
from timonel.recording.series import MOST, Series, series
from timonel.recording.track import track

LOG = "canboat_canboat/samples/susteranna2020.raw"
AAVA = "SignalK_signalk-server/samples/aava-n2k.data"
GPX = "{http://www.topografix.com/GPX/1/1}"


def path(name):
    return str(recording(name))


def data(page):
    text = page.read_text()
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)[1])


def offline(page):
    """Whether nothing in the page is fetched from anywhere."""
    return not re.search(
        r"\b(src|href|action|srcset)\s*=|url\(|@import|fetch\(|XMLHttpRequest|WebSocket", page.read_text()
    )


def test_a_plot_has_the_values_in_the_units_of_people(tmp_path):
    page = tmp_path / "plot.html"
    done = timonel("plot", path(LOG), "vesselHeading.heading", "sog", "-o", str(page))
    assert done.returncode == 0, done.stderr
    found = data(page)
    angles, speeds = found["charts"]
    assert (angles["unit"], angles["circular"], speeds["unit"]) == ("°", True, "kn")
    heading = library.columns(path(LOG), "vesselHeading")
    kept = ~np.isnan(heading["heading"])
    shown = [value for one in angles["series"] for value in one["value"] if value is not None]
    assert len(shown) == kept.sum()
    assert sorted(value % 360 for value in shown) == pytest.approx(
        sorted(np.degrees(heading["heading"][kept])), abs=0.01
    )
    assert found["begin"] == pytest.approx(np.nanmin(heading.time), abs=1.0)


@pytest.mark.parametrize("program", [("plot", "heading"), ("track",)])
def test_a_page_needs_no_network(tmp_path, program):
    page = tmp_path / "page.html"
    timonel(program[0], path(AAVA if program[0] == "track" else LOG), *program[1:], "-o", str(page))
    assert offline(page)
    assert "$" + "data" not in page.read_text()


def test_the_name_of_a_file_cannot_end_the_element_that_it_stands_in(tmp_path):
    log = tmp_path / "<b>&.raw"
    log.write_bytes(recording(LOG).read_bytes())
    timonel("plot", str(log), "heading", "-o", str(tmp_path / "plot.html"))
    assert "<title>&lt;b&gt;&amp;.raw</title>" in (tmp_path / "plot.html").read_text()


def test_a_heading_does_not_jump_at_north(tmp_path):
    log = tmp_path / "turn.log"
    lines = []
    for number, angle in enumerate(range(300, 800, 20)):
        raw = round(np.radians(angle % 360) * 10000).to_bytes(2, "little").hex().upper()
        lines.append(f"({1_700_000_000 + number}.000000) can0 09F11201#00{raw}FF7FFF7FFD\n")
    log.write_text("".join(lines))
    (one,), dated = series(log, ["heading"])
    assert dated
    assert np.diff(one.value) == pytest.approx(20, abs=0.01)


def test_sources_instances_and_references_are_lines_of_their_own(tmp_path):
    log = tmp_path / "two.log"
    log.write_text(
        "(1.000000) can0 09FD0201#00640010270002FF\n"
        "(1.100000) can0 09FD0201#0064001027FAFFFF\n"
        "(2.000000) can0 09FD0202#0064001027FAFFFF\n"
    )
    found, _ = series(log, ["windAngle"])
    assert {one.name for one in found} == {
        "windData.windAngle (1, True (ground referenced to North))",
        "windData.windAngle (1, Apparent)",
        "windData.windAngle (2, Apparent)",
    }


def test_a_message_stands_for_all_its_values_with_a_unit():
    found, _ = series(path(LOG), ["rudder"])
    assert {one.name.split(" ")[0] for one in found} <= {"rudder.position", "rudder.angleOrder"}


def test_of_many_points_the_highest_and_the_lowest_are_kept(tmp_path):
    log = tmp_path / "long.log"
    raws = np.full(5 * MOST, 100)
    raws[12345], raws[54321] = 5000, 1
    data_of = [f"00FC0000{int(raw).to_bytes(2, 'little').hex().upper()}FFFF" for raw in raws]
    lines = (f"({1_700_000_000 + number}.000000) can0 09F80201#{data}\n" for number, data in enumerate(data_of))
    log.write_text("".join(lines))
    (one,), _ = series(log, ["cogSogRapidUpdate.sog"])
    assert isinstance(one, Series)
    assert len(one.time) <= 2 * MOST
    assert (np.nanmax(one.value), np.nanmin(one.value)) == pytest.approx((50 * 3600 / 1852, 0.01 * 3600 / 1852))


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("hedding", 'did you mean "heading"'),
        ("vesselHeading.hedding", 'did you mean "heading"'),
        ("vesselHedding.heading", 'did you mean "vesselHeading"'),
        ("dewpoint", "has no values of dewpoint"),
    ],
)
def test_a_name_that_nothing_has_is_refused(tmp_path, name, told):
    done = timonel("plot", path(LOG), name, "-o", str(tmp_path / "plot.html"))
    assert done.returncode == 1
    assert told in done.stderr.decode()


def test_a_track_has_the_positions_of_the_source_with_most(tmp_path):
    page = tmp_path / "track.html"
    assert timonel("track", path(AAVA), "-o", str(page)).returncode == 0
    found = data(page)
    positions = library.columns(path(AAVA), "positionRapidUpdate")
    kept = positions["latitude"][(positions.source == 160) & ~np.isnan(positions["latitude"])]
    assert [value for value in found["lat"] if value is not None] == pytest.approx(kept.tolist(), abs=1e-7)
    assert found["speed"][0] == pytest.approx(6.7, abs=0.2)


def test_a_track_is_written_as_gpx(tmp_path):
    file = tmp_path / "track.gpx"
    timonel("track", path(AAVA), "-o", str(file))
    points = ElementTree.parse(file).getroot().findall(f"{GPX}trk/{GPX}trkseg/{GPX}trkpt")
    assert len(points) == 597
    assert (float(points[0].get("lat")), float(points[0].get("lon"))) == pytest.approx((59.7249, 24.7366), abs=1e-3)
    assert points[0].find(f"{GPX}time").text.startswith("2014-08-15T19:00:0")


def test_a_track_is_interrupted_where_positions_are_missing(tmp_path):
    log = tmp_path / "gap.log"
    fix = "can0 09F80101#00E1F50500E1F505"
    log.write_text("".join(f"({1_700_000_000 + second}.000000) {fix}\n" for second in (0, 1, 100, 101)))
    found = track(log)
    assert np.flatnonzero(np.isnan(found.latitude)).tolist() == [2]


def test_a_recording_without_positions_has_no_track(tmp_path):
    done = timonel("track", path("canboat_canboat/samples/ws320.raw"), "-o", str(tmp_path / "track.html"))
    assert (done.returncode, b"has no positions" in done.stderr) == (1, True)
    done = timonel("track", path(AAVA), "--source", "99", "-o", str(tmp_path / "track.html"))
    assert b"has no positions of source 99" in done.stderr
