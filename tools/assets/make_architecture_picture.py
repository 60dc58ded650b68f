"""Draws docs/inside/architecture.svg: the rings and floors of pyproject.toml, above the folders of cpp/uwsim.

.venv/bin/python tools/assets/make_architecture_picture.py
"""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs/inside/architecture.svg"
WIDTH, MARGIN, GAP, ROW, HEAD = 1000, 20, 10, 34, 34
GREEN = "#eef7ee"
STYLE = """<style>.h{font-size:15px;font-weight:bold;fill:#1b2733}.b{font-size:14px;font-weight:bold;fill:#1b2733}
.s{font-size:12px;fill:#4a5a68}</style>"""
TEXTS = {
    "examples": "programs to copy",
    "cli": "the uwsim command",
    "flight": "flies a mission or a survey: map, log, report",
    "figures": "pictures of maps, scenes, flights",
    "scoring": "a map against the true world",
    "missions": "steps, moves, planners",
    "batch": "many simulations in one call",
    "live": "a simulator that follows the wall clock",
    "simulator": "world, vehicles, helm, faults, saved states, journal",
    "instruments": "sensors, sonars, cameras, sound",
    "navigation": "control loops, the pose from instruments",
    "scenario": "YAML files: read, check, build",
    "mapping": "from ranges to an OctoMap",
    "base": "what all rooms share",
    "connect": "ROS 1 and 2, rosbridge, Foxglove, links, recordings",
    "autopilots": "ArduSub, MAVLink, video",
    "station": "the page, exercises, teleop",
    "learning": "Gymnasium environments",
    "campaigns": "sweeps, fleets, data sets",
    "league": "teams' programs over courses",
    "exchange": "robots, charts, logs of others",
    "evidence": "validation, reproductions",
}
"""A line for each room of the heart, and for each add-on."""


def main() -> None:
    """Write the picture."""
    PICTURE.write_text(picture())


def picture() -> str:
    """Return the picture. Raises KeyError for a room or add-on without a line in TEXTS."""
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
    heart = tools["uwsim"]["heart"]["rooms"]
    needs = {name: set(add_on["needs"]) for name, add_on in tools["uwsim"]["add-ons"].items()}
    layers = tools["importlinter"]["contracts"][0]["layers"]
    floors = [[name.strip(" ()") for name in layer.split("|")] for layer in layers]
    floors = [floor for names in floors if (floor := [name for name in names if name in heart])]
    parts, y = [], MARGIN
    for title, colour, rows, texts in (
        ("Add-ons: each imports the heart, and add-ons below it", GREEN, _rows(needs), TEXTS),
        ("The heart: a floor imports only the floors below it", "#eef4fb", floors, TEXTS),
        ("The core, in C++: a folder includes only folders below it", "#fbf3e8", _rows(_folders()), {}),
    ):
        height = HEAD + len(rows) * (ROW + GAP)
        parts += [
            _box(MARGIN, y, WIDTH - 2 * MARGIN, height, colour, ""),
            _text(MARGIN + 15, y + 22, title, "h", "start"),
        ]
        for number, row in enumerate(rows):
            parts += _row(row, texts, set(needs) if not texts else set(), y + HEAD + number * (ROW + GAP))
        y += height + GAP
    return "\n".join((
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + MARGIN - GAP}" '
        'font-family="Helvetica, Arial, sans-serif">',
        "<title>The heart of uwsim on its core, and the add-ons around it</title>",
        STYLE,
        f'<rect width="{WIDTH}" height="{y + MARGIN - GAP}" fill="#ffffff"/>',
        *parts,
        "</svg>\n",
    ))  # fmt: skip


def _folders() -> dict[str, set[str]]:
    """Return what each folder of cpp/uwsim may include: the table MAY_INCLUDE of the tests."""
    tree = ast.parse((ROOT / "tests/python/whole/test_architecture.py").read_text())
    table = next(
        node for node in tree.body if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "MAY_INCLUDE"
    )
    assert isinstance(table.value, ast.Dict)
    return {
        ast.literal_eval(key): set() if isinstance(value, ast.Call) else ast.literal_eval(value)
        for key, value in zip(table.value.keys, table.value.values, strict=True) if key is not None
    }  # fmt: skip


def _rows(needs: Mapping[str, set[str]]) -> list[list[str]]:
    """Return names in rows, the ones that need nothing last."""

    def depth(name: str) -> int:
        return max((1 + depth(need) for need in needs[name]), default=0)

    rows: dict[int, list[str]] = {}
    for name in needs:
        rows.setdefault(depth(name), []).append(name)
    return [rows[number] for number in sorted(rows, reverse=True)]


def _row(names: Sequence[str], texts: Mapping[str, str], tinted: set[str], y: float) -> Iterator[str]:
    left, right = MARGIN + 15, WIDTH - MARGIN - 15
    width = (right - left - GAP * (len(names) - 1)) / len(names)
    for number, name in enumerate(names):
        x = left + number * (width + GAP)
        yield _box(x, y, width, ROW, GREEN if name in tinted else "#ffffff", ' stroke="#1b2733" stroke-width="1.2"')
        lines = [(name, "b"), *([(texts[name], "s")] if texts else [])]
        for line, (text, style) in enumerate(lines):
            yield _text(x + width / 2, y + ROW / 2 + (5 if len(lines) == 1 else -2 + 14 * line), text, style, "middle")


def _box(x: float, y: float, width: float, height: float, fill: str, stroke: str) -> str:
    return f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="8" fill="{fill}"{stroke}/>'


def _text(x: float, y: float, text: str, style: str, anchor: str) -> str:
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" class="{style}">{escape(text)}</text>'


if __name__ == "__main__":
    main()
