"""A table as the documentation has it."""

from collections.abc import Mapping

Columns = Mapping[str, tuple[str, str]]
"""Heading to the figure's name and its format."""


def table(rows: Mapping[str, Mapping[str, float]], columns: Columns) -> str:
    """Markdown, padded so that it reads as text too."""
    cells = [["", *columns]]
    for name, row in rows.items():
        cells.append([name, *(format(row[key], how) if key in row else "" for key, how in columns.values())])
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [_line(line, widths) for line in cells]
    rule = "|" + "-" * (widths[0] + 2) + "|" + "".join("-" * (width + 1) + ":|" for width in widths[1:])
    lines.insert(1, rule)
    return "\n".join(lines) + "\n"


def _line(cells: list[str], widths: list[int]) -> str:
    name, *figures = cells
    padded = [name.ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(figures, widths[1:], strict=True))]
    return "| " + " | ".join(padded) + " |"
