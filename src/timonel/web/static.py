"""The files that a browser loads: those in `static/`, by their own names and no others.

Each is read and packed once and again when it changes. What is named after its content (`name-1a2b3c4d.js`) is kept by
the browser for ever; of all else it asks each time whether it is still the same.
"""

import gzip
import hashlib
import re
from mimetypes import guess_type
from pathlib import Path

import msgspec

ROOT = Path(__file__).parent / "static"
NAMED = re.compile(r".*[-.][0-9a-f]{8,}\.\w+")
TYPES = {
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".css": "text/css",
    ".html": "text/html",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
    ".wasm": "application/wasm",
}
TEXT = ("text/", "application/json", "application/manifest+json", "image/svg+xml", "application/wasm")
WORTH_PACKING = 512  # bytes
NOT_SERVED = (".d.ts", ".map", ".md")


class File(msgspec.Struct, frozen=True):
    """What is sent: plain and, where that is smaller, packed."""

    plain: bytes
    packed: bytes | None
    kind: str
    etag: str
    cache: str
    stamp: tuple[int, int]


class Files:
    """The files under a directory."""

    def __init__(self, root: Path = ROOT) -> None:
        self._root = root
        self._files: dict[str, File] = {}

    def get(self, name: str) -> File | None:
        """The file called `name`, "" is index.html; None if there is none."""
        path = self._path(name or "index.html")
        if path is None:
            return None
        status = path.stat()
        stamp = (status.st_mtime_ns, status.st_size)
        file = self._files.get(name)
        if file is None or file.stamp != stamp:
            file = self._files[name] = _load(path, stamp)
        return file

    def _path(self, name: str) -> Path | None:
        """Every part is a plain name, and none leads out of the directory."""
        parts = name.split("/")
        if not all(re.fullmatch(r"[A-Za-z0-9_][\w.@-]*", part, re.ASCII) for part in parts) or name.endswith(
            NOT_SERVED
        ):
            return None
        path = self._root.joinpath(*parts)
        inside = path.resolve().is_relative_to(self._root.resolve())
        return path if inside and path.is_file() else None


def _load(path: Path, stamp: tuple[int, int]) -> File:
    plain = path.read_bytes()
    kind = TYPES.get(path.suffix) or guess_type(path.name)[0] or "application/octet-stream"
    text = kind.startswith(TEXT)
    packed = gzip.compress(plain, 9, mtime=0) if text and len(plain) >= WORTH_PACKING else None
    return File(
        plain,
        packed if packed is not None and len(packed) < len(plain) else None,
        f"{kind}; charset=utf-8" if kind.startswith("text/") else kind,
        f'"{hashlib.blake2b(plain, digest_size=12).hexdigest()}"',
        "public, max-age=31536000, immutable" if NAMED.fullmatch(path.name) else "no-cache",
        stamp,
    )
