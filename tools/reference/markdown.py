"""Markdown tables and escapes."""

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells are Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def code(text: str) -> str:
    """Return text as code; empty text stays empty."""
    return f"`{text}`" if text else ""


def plain(text: str) -> str:
    """Return text on one line, with all markup escaped."""
    line = " ".join(text.split())
    for mark in ("\\", "*", "_", "<", "[", "]", "`", "$"):
        line = line.replace(mark, "\\" + mark)
    return line
