"""Writes src/timonel/web/static/messages.d.ts from the declarations in `timonel.web.messages`."""

from inspect import cleandoc
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import msgspec

from timonel.web import messages

PATH = Path(messages.__file__).parent / "static" / "messages.d.ts"
HEAD = "// Written by scripts/make_types.py from timonel/web/messages.py; do not edit.\n"
PLAIN = {str: "string", int: "number", float: "number", bool: "boolean", NoneType: "null", Any: "unknown"}
BASES = (messages.Topic, messages.FromServer, messages.FromBrowser)
WORDS = {value: name for name, value in vars(messages).items() if get_origin(value) is Literal}
UNIONS = {name: value for name, value in vars(messages).items() if isinstance(value, UnionType)}


def page() -> str:
    """The whole file."""
    aliases = [f"export type {name} = {_literal(value)};\n" for value, name in WORDS.items()]
    declared = [value for value in vars(messages).values() if _is_declared(value)]
    unions = [
        f"export type {name} = {' | '.join(part.__name__ for part in get_args(value))};\n"
        for name, value in UNIONS.items()
    ]
    about = _comment(cleandoc(messages.__doc__ or ""))
    return "\n".join([HEAD + about, "".join(aliases), *map(_interface, declared), "".join(unions)])


def _is_declared(value: object) -> bool:
    return isinstance(value, type) and issubclass(value, BASES) and value not in BASES


def _interface(struct: type[msgspec.Struct]) -> str:
    hints = get_type_hints(struct, include_extras=True)
    config = struct.__struct_config__
    lines = [f'  {config.tag_field}: "{config.tag}";\n'] if config.tag else []
    for field in msgspec.structs.fields(struct):
        lines.append(f"  {field.name}{'' if field.required else '?'}: {_type(hints[field.name])};\n")
    return f"{_comment(cleandoc(struct.__doc__ or ''))}export interface {struct.__name__} {{\n{''.join(lines)}}}\n"


def _comment(text: str) -> str:
    lines = text.splitlines()
    if len(lines) == 1:
        return f"/** {lines[0]} */\n"
    return "/**\n" + "".join(f" * {line}".rstrip() + "\n" for line in lines) + " */\n"


def _type(hint: Any) -> str:
    if hint in WORDS:
        return WORDS[hint]
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        written = [meta.extra["ts"] for meta in arguments[1:] if meta.extra]
        return written[0] if written else _type(arguments[0])
    if origin is Literal:
        return _literal(hint)
    if origin in (Union, UnionType):
        return " | ".join(map(_type, arguments))
    if origin is list:
        element = _type(arguments[0])
        return f"({element})[]" if "|" in element else f"{element}[]"
    if hint in PLAIN:
        return PLAIN[hint]
    return str(hint.__name__)


def _literal(hint: Any) -> str:
    return " | ".join(f'"{word}"' for part in get_args(hint) for word in _literal_words(part))


def _literal_words(part: Any) -> tuple[str, ...]:
    return (part,) if isinstance(part, str) else tuple(word for each in get_args(part) for word in _literal_words(each))


if __name__ == "__main__":
    PATH.write_text(page())
