"""The node map, drawn from a running system's data (Fig. 11): nodes and topics in columns, no line behind another name.

Every column has its own slot for each line that passes it, so that lines meet boxes only at their ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path as Line

from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.running_system import Edge
from uwsim.figures.style import ACCENT, FAINT_INK, INK, new_figure, save_figure

SIMULATOR = "simulator"
PARTS = {
    "key": "force control",
    "image/compressed": "station camera",
    "images/compressed": "front, down camera",
    "depthArray": "sonar",
    "scanPos": "sonar",
    "modelTrigger": "sonar",
    "hFOV": "sonar",
}
"""The part of the simulator that has each of its topics; the vehicle has the others."""
COLUMN_IN, SLOT_IN, BOX_IN, CHARACTER_IN = 1.62, 0.46, 0.28, 0.078
SWEEPS = 24


@dataclass
class Vertex:
    """A node, a topic, or the place at which a line passes a column ("")."""

    name: str
    column: int
    is_topic: bool = False
    before: list[Vertex] = field(default_factory=list, repr=False)
    after: list[Vertex] = field(default_factory=list, repr=False)
    y: float = 0.0

    @property
    def half_in(self) -> float:
        """Half of the width of its box [in]."""
        return 0.5 * (CHARACTER_IN * len(self.name) + 0.16) if self.name else 0.0


def node_map(edges: Sequence[Edge], path: Path) -> Figure:
    """Draw Fig. 11, the node map."""
    vertices = layered(edges)
    arrange(vertices)
    columns = 1 + max(vertex.column for vertex in vertices)
    low, high = min(v.y for v in vertices), max(v.y for v in vertices)
    width, height = COLUMN_IN * columns, SLOT_IN * (high - low + 3.0)
    figure = new_figure(width, height)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    for vertex in vertices:
        vertex.y = SLOT_IN * (high - vertex.y + 1.0)
    _band(axes, [vertex for vertex in vertices if vertex.is_topic and vertex.column == 1])
    for vertex in vertices:
        _draw_box(axes, vertex)
        for end in vertex.after if vertex.name else ():
            _draw_line(axes, vertex, end)
    save_figure(figure, path)
    return Figure(
        11,
        "The node map",
        "The simulator's parts and topics (left), the nodes of the paper's chain and their topics, from rosapi. A "
        "topic without an arrow has no reader among the nodes.",
        "Theirs needs a ROS installation; in ours, the simulator's own rosbridge carries all topics between the same "
        "nodes. Their scan publisher also reads hFOV, without using it.",
        columns=("publisher", "topic", "subscriber"),
        rows=[_row(edge) for edge in edges],
    )


def _row(edge: Edge) -> tuple[str, str, str]:
    part = f"{SIMULATOR}: {PARTS.get(edge.topic, 'vehicle')}"
    publisher, subscriber = (part if name == SIMULATOR else name for name in (edge.publisher, edge.subscriber))
    return publisher, edge.topic, subscriber or "none"


def layered(edges: Iterable[Edge]) -> list[Vertex]:
    """Return nodes, topics and passed columns, from left to right by the longest path from the simulator.

    What a node sends to the simulator runs from right to left. A loop among the nodes raises ValueError.
    """
    forward: list[tuple[str, str]] = []  # topics have a "/" before their name
    for edge in edges:
        topic, part = f"/{edge.topic}", PARTS.get(edge.topic, "vehicle")
        if edge.subscriber == SIMULATOR:
            forward += [(part, topic), (topic, edge.publisher)]
        else:
            forward.append((part if edge.publisher == SIMULATOR else edge.publisher, topic))
            forward += [(topic, edge.subscriber)] if edge.subscriber else []
    forward = list(dict.fromkeys(forward))
    column = dict.fromkeys((name for pair in forward for name in pair), 0)
    for _ in column:
        for start, end in forward:
            column[end] = max(column[end], column[start] + 1)
    if any(column[end] <= column[start] for start, end in forward):
        raise ValueError("the nodes form a loop")
    vertices = {name: Vertex(name.removeprefix("/"), at, name.startswith("/")) for name, at in column.items()}
    passed: list[Vertex] = []
    for start, end in forward:
        last = vertices[start]
        for at in range(column[start] + 1, column[end]):
            passed.append(Vertex("", at))
            _join(last, passed[-1])
            last = passed[-1]
        _join(last, vertices[end])
    return [*vertices.values(), *passed]


def _join(start: Vertex, end: Vertex) -> None:
    start.after.append(end)
    end.before.append(start)


def arrange(vertices: Sequence[Vertex]) -> None:
    """Set each vertex's slot y, at least 1 from the next in its column, near the mean of those that it is joined to."""
    columns: dict[int, list[Vertex]] = {}
    for vertex in vertices:
        columns.setdefault(vertex.column, []).append(vertex)
    for inside in columns.values():
        for slot, vertex in enumerate(inside):
            vertex.y = slot - 0.5 * (len(inside) - 1)
    for sweep in range(SWEEPS):
        for at in sorted(columns, reverse=bool(sweep % 2)):
            wanted = {id(v): float(np.mean([o.y for o in (*v.before, *v.after)] or [v.y])) for v in columns[at]}
            columns[at].sort(key=lambda vertex: wanted[id(vertex)])
            slots = np.array([wanted[id(vertex)] for vertex in columns[at]])
            spread = slots.copy()
            for here in range(1, len(spread)):
                spread[here] = max(spread[here], spread[here - 1] + 1.0)
            spread -= np.mean(spread - slots)
            for vertex, slot in zip(columns[at], spread.tolist(), strict=True):
                vertex.y = slot


def _x_in(vertex: Vertex) -> float:
    return COLUMN_IN * (vertex.column + 0.5)


def _draw_box(axes: Axes, vertex: Vertex) -> None:
    if not vertex.name:
        return
    x, half = _x_in(vertex), vertex.half_in
    style = "round,pad=0,rounding_size=0.14" if vertex.is_topic else "round,pad=0,rounding_size=0.03"
    axes.add_patch(
        FancyBboxPatch(
            (x - half, vertex.y - 0.5 * BOX_IN),
            2.0 * half,
            BOX_IN,
            boxstyle=style,
            zorder=3,
            linewidth=0.9,
            facecolor="white" if vertex.is_topic else "#eef4f8",
            edgecolor=ACCENT if vertex.is_topic else INK,
        )
    )
    colour = ACCENT if vertex.is_topic else INK
    axes.text(x, vertex.y, vertex.name, fontsize=8.5, color=colour, ha="center", va="center_baseline", zorder=4)


def _draw_line(axes: Axes, start: Vertex, end: Vertex) -> None:
    """Draw the line that begins with start and end, through the columns that it passes, with its arrow."""
    way = [start, end]
    while not way[-1].name:
        way.append(way[-1].after[0])
    places = [(_x_in(vertex), vertex.y) for vertex in way]
    places[0] = places[0][0] + way[0].half_in, places[0][1]
    places[-1] = places[-1][0] - way[-1].half_in, places[-1][1]
    corners, codes = [places[0]], [Line.MOVETO]
    for (x0, y0), (x1, y1) in pairwise(places):
        corners += [(0.5 * (x0 + x1), y0), (0.5 * (x0 + x1), y1), (x1, y1)]
        codes += 3 * [Line.CURVE4]
    if "key" in (way[0].name, way[-1].name):  # the one topic that runs to the simulator
        corners.reverse()
    arrow = FancyArrowPatch(
        path=Line(corners, codes), arrowstyle="-|>", mutation_scale=10, color=FAINT_INK, linewidth=1.0
    )
    axes.add_patch(arrow)


def _band(axes: Axes, topics: Sequence[Vertex]) -> None:
    """Draw the simulator's rosbridge behind its topics."""
    low, high = min(v.y for v in topics), max(v.y for v in topics)
    half = max(v.half_in for v in topics) + 0.1
    corner = _x_in(topics[0]) - half, low - 0.32
    axes.add_patch(
        FancyBboxPatch(
            corner,
            2.0 * half,
            high - low + 0.86,
            boxstyle="round,pad=0,rounding_size=0.08",
            facecolor="#f4f1ea",
            edgecolor="none",
            zorder=0,
        )
    )
    axes.text(
        _x_in(topics[0]), high + 0.36, "rosbridge", fontsize=9.5, color=INK, ha="center", va="center", fontweight="bold"
    )
