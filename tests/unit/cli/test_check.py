from pathlib import Path

from tests.unit.cli.programs import timonel

DOCS = Path(__file__).parents[3] / "docs"


def test_a_sound_configuration_is_said_to_be_fine() -> None:
    run = timonel("check", str(DOCS / "boat.toml"))
    assert run.returncode == 0
    assert run.stdout.decode().partition("boat.toml: ")[2] == (
        "fine: 3 stations, 1 output, bus slcan:///dev/ttyACM0?bitrate=250000\n"
    )


def test_all_mistakes_are_told_and_the_status_is_2(tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    path.write_text('[vehicle]\nkind = "boat"\n[bus]\nurl = "sockcan://can0"\n')
    run = timonel("check", str(path))
    assert run.returncode == 2
    assert run.stderr.decode().splitlines() == [
        f"{path}, station: missing; without a [[station]] or an [[output]] nobody hears anything",
        f'{path}:4, bus.url: unknown scheme "sockcan" (did you mean "socketcan"?)',
    ]
    assert run.stdout == b""
