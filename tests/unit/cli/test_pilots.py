"""`timonel pilots`, as a user calls it."""

import json
from pathlib import Path

from tests.recordings import recording
from tests.unit.cli.programs import timonel
from timonel.vehicles.boat.pilots import KINDS

DOCS = Path(__file__).parents[3] / "docs"


def test_every_driver_is_told_with_its_evidence_and_that_none_was_tried() -> None:
    run = timonel("pilots")
    told = " ".join(run.stdout.decode().split())
    assert run.returncode == 0
    assert all(name in told for name in KINDS)
    assert {"standard", "captured", "reverse-engineered"} == {str(kind.evidence) for kind in KINDS.values()}
    assert all(str(kind.evidence) in told for kind in KINDS.values())
    assert "No driver was ever tried on a real pilot by us" in told


def test_programs_get_a_line_a_driver() -> None:
    told = [json.loads(line) for line in timonel("pilots", "--json").stdout.splitlines()]
    assert [kind["name"] for kind in told] == list(KINDS)
    assert [kind["name"] for kind in told if not kind["absolute"]] == ["navico", "garmin"]


def test_the_pilots_of_a_bus_are_told_with_the_name_to_configure() -> None:
    ev1 = str(recording("canboat_canboat/samples/raymarine-ev1.raw"))
    told = timonel("pilots", ev1).stdout.decode()
    assert "204" in told
    assert "raymarine" in told
    assert '"0xC0509635E761AEC1"' in told
    (found,) = [json.loads(line) for line in timonel("pilots", ev1, "--json").stdout.splitlines()]
    assert found["drivers"] == ["standard", "groupfunction", "raymarine"]
    assert found["device"]["address"] == 204


def test_a_bus_without_a_pilot_is_told_so() -> None:
    run = timonel("pilots", str(recording("canboat_canboat/samples/candumpSample2.txt")))
    assert run.stdout.decode() == "no device says that it is an autopilot\n"


def test_the_demo_knows_which_pilots_it_can_play_and_that_a_rover_has_none() -> None:
    unknown = timonel("demo", "--pilot", "raymarin")
    assert unknown.returncode == 2
    assert b"there is one for standard, groupfunction, raymarine, raymarine-spx, navico, garmin" in unknown.stderr
    assert b"only the boat has a pilot" in timonel("demo", "rover", "--pilot", "raymarine").stderr


def test_every_makers_page_says_that_nothing_was_tried_on_a_real_pilot() -> None:
    for page in ("raymarine.md", "navico.md", "garmin.md"):
        assert "never tried on a real pilot" in " ".join((DOCS / page).read_text().split())
