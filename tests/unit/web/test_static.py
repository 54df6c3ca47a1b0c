"""The files that a browser loads."""

import gzip
import os
from pathlib import Path

import pytest

from timonel.web.static import ROOT, Files


@pytest.fixture
def files(tmp_path: Path) -> Files:
    root = tmp_path / "static"
    (root / "vendor").mkdir(parents=True)
    (root / "index.html").write_text("<!doctype html>" + "x" * 1000)
    (root / "app.js").write_text("export {};")
    (root / "vendor" / "plot-1a2b3c4d.js").write_text("y" * 1000)
    (root / "icon.png").write_bytes(os.urandom(2000))
    (root / "messages.d.ts").write_text("")
    (tmp_path / "secret").write_text("secret")
    (root / "way-out").symlink_to(tmp_path / "secret")
    return Files(root)


def test_a_file_is_served_with_its_kind(files: Files) -> None:
    file = files.get("app.js")
    assert file is not None
    assert (file.plain, file.kind) == (b"export {};", "text/javascript; charset=utf-8")
    assert file.packed is None, "too small to be worth it"


def test_the_page_without_a_name_is_the_first(files: Files) -> None:
    first = files.get("")
    assert first == files.get("index.html")
    assert first is not None
    assert first.packed is not None
    assert gzip.decompress(first.packed) == first.plain


def test_what_does_not_get_smaller_is_not_packed(files: Files) -> None:
    file = files.get("icon.png")
    assert file is not None
    assert (file.kind, file.packed) == ("image/png", None)


def test_what_is_named_after_its_content_is_kept_and_all_else_asked_for(files: Files) -> None:
    named, other = files.get("vendor/plot-1a2b3c4d.js"), files.get("app.js")
    assert named is not None
    assert other is not None
    assert named.cache == "public, max-age=31536000, immutable"
    assert other.cache == "no-cache"


def test_a_file_that_changes_is_another(files: Files, tmp_path: Path) -> None:
    before = files.get("app.js")
    assert files.get("app.js") is before
    (tmp_path / "static" / "app.js").write_text("export const changed = true;")
    after = files.get("app.js")
    assert before is not None
    assert after is not None
    assert (before.etag, before.plain) != (after.etag, after.plain)


@pytest.mark.parametrize(
    "name",
    [
        "../secret", "vendor/../../secret", "..", ".", "/etc/passwd", "//etc/passwd", "vendor", "vendor/", "app.js/",
        "way-out", "messages.d.ts", ".hidden", "app.js\x00", "..\\secret", "vendor//plot-1a2b3c4d.js", "%2e%2e/secret",
        "nothing", "\u2025/secret", "~root", "app.js\n",
    ],
)  # fmt: skip
def test_nothing_leads_out_of_the_directory(files: Files, name: str) -> None:
    assert files.get(name) is None


def test_every_file_of_the_console_can_be_loaded() -> None:
    files = Files()
    names = [path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*") if path.is_file()]
    served = [name for name in names if not name.endswith((".d.ts", ".map", ".md"))]
    assert served
    assert [name for name in served if files.get(name) is None] == []
