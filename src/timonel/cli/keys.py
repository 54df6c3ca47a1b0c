"""Keys out of the bytes of a terminal.

```
bytes                       key
a printable character       itself
ESC [ A, ESC O A            up, and so on
ESC [ 1 ; 2 A, ESC [ a      shift-up, and so on (xterm and its kin, rxvt)
CR, LF / DEL, BS            enter / backspace
ESC and nothing after it    escape, when `expire` is called
any other sequence          nothing
```
A sequence may come in pieces.
"""

import re

_TOKEN = re.compile(rb"\x1b\[(?P<parameters>[0-?]*)[ -/]*(?P<final>[@-~])|\x1bO(?P<ss3>[@-~])|(?P<plain>[^\x1b])", re.S)
_UNFINISHED = re.compile(rb"\x1b(\[[0-?]*[ -/]*|O)?\Z")
_ARROWS = {b"A": "up", b"B": "down", b"C": "right", b"D": "left"}
_CONTROLS = {b"\r": "enter", b"\n": "enter", b"\x7f": "backspace", b"\x08": "backspace"}
_SHIFT = 1


class Keys:
    """Puts the keys together; `pending` while a sequence is unfinished."""

    def __init__(self) -> None:
        self._rest = b""

    @property
    def pending(self) -> bool:
        return bool(self._rest)

    def receive(self, data: bytes) -> list[str]:
        """The keys that `data` completes."""
        data, self._rest = self._rest + data, b""
        keys, at = [], 0
        while at < len(data):
            if token := _TOKEN.match(data, at):
                keys.append(_key(token))
                at = token.end()
            elif _UNFINISHED.match(data, at):
                self._rest = data[at:]
                break
            else:
                keys.append("escape")
                at += 1
        return [key for key in keys if key]

    def expire(self) -> list[str]:
        """Nothing came after it for a while: a lone ESC is the escape key, any other beginning is nothing."""
        rest, self._rest = self._rest, b""
        return ["escape"] if rest == b"\x1b" else []


def _key(token: re.Match[bytes]) -> str:
    if plain := token["plain"]:
        return _CONTROLS.get(plain) or (plain.decode() if b" " <= plain <= b"~" else "")
    if token["ss3"]:
        return _ARROWS.get(token["ss3"], "")
    arrow = _ARROWS.get(token["final"].upper(), "")
    return f"shift-{arrow}" if arrow and _shifted(token["parameters"], token["final"]) else arrow


def _shifted(parameters: bytes, final: bytes) -> bool:
    modifier = parameters.rpartition(b";")[2] if b";" in parameters else b""
    return final.islower() or (modifier.isdigit() and bool(int(modifier) - 1 & _SHIFT))
