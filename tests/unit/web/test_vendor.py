"""What the console has from others: listed with version, licence and hash, and nothing else."""

import hashlib
import json
from pathlib import Path

ROOT = Path(__file__).parents[3]
VENDOR = ROOT / "src" / "timonel" / "web" / "static" / "vendor"
LISTED = {entry["file"]: entry for entry in json.loads((VENDOR / "vendor.json").read_text())}
PINNED = json.loads((ROOT / "package.json").read_text())["devDependencies"]


def test_every_file_is_listed_and_is_what_was_listed() -> None:
    there = {path.name for path in VENDOR.iterdir()} - {"vendor.json", "LICENSES.txt"}
    assert {name for name in there if not name.endswith(".d.ts")} == LISTED.keys()
    for name, entry in LISTED.items():
        content = (VENDOR / name).read_bytes()
        assert hashlib.sha256(content).hexdigest() == entry["sha256"], name
        assert len(content) == entry["bytes"], name


def test_every_file_has_a_licence_and_the_version_that_is_pinned() -> None:
    for name, entry in LISTED.items():
        assert entry["licence"] in {"Apache-2.0", "MIT", "BSD-2-Clause", "OFL-1.1"}, name
        assert PINNED[entry["package"]] == entry["version"], name


def test_every_package_is_named_in_the_notice_and_its_licence_is_there() -> None:
    notice, licences = (ROOT / "NOTICE").read_text(), (VENDOR / "LICENSES.txt").read_text()
    for package in {entry["package"] for entry in LISTED.values()}:
        assert package in notice
        assert f"{package} {PINNED[package]} (" in licences
