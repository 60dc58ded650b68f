"""The transform tree and the node map, drawn from a running system's data (Figs. 10 and 11)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes

from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.running_system import Edge, Link
from uwsim.figures.style import ACCENT, FAINT_INK, INK, new_figure, save_figure

Place = tuple[float, float]
BEND = 0.22
ASPECT = 12.0 / 4.6  # aspect ratio (width to height) of the node map
BOX = {"boxstyle": "round,pad=0.45", "facecolor": "#eef4f8", "edgecolor": INK, "linewidth": 0.9}


def transform_tree(published: Sequence[Link], standard: Sequence[Link], path: Path) -> Figure:
    """Draw Fig. 10, the transform tree."""
    figure = new_figure(12.0, 7.6)
    left, right = figure.add_axes((0.0, 0.0, 0.24, 1.0)), figure.add_axes((0.26, 0.0, 0.74, 1.0))
    _draw_tree(left, published, "the published nodes' /tf")
    _draw_tree(right, standard, "the standard topics")
    save_figure(figure, path)
    rows = [(tree, link.parent, link.child, link.rate_hz or "static")
            for tree, links in (("published", published), ("standard", standard)) for link in links]  # fmt: skip
    return Figure(
        10, "The transform tree", "From the topics of a running system, with the rate of each moving transform.",
        "Theirs has the first tree; ours has the standard topics' tree, too.",
        columns=("wire", "parent", "child", "rate [Hz]"), rows=rows,
    )  # fmt: skip


def node_map(edges: Sequence[Edge], path: Path) -> Figure:
    """Draw Fig. 11, the node map."""
    figure = new_figure(12.0, 4.6)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    _bare(axes, "Nodes and topics")
    by_pair: dict[tuple[str, str], list[str]] = {}
    for edge in edges:
        by_pair.setdefault((edge.publisher, edge.subscriber), []).append(edge.topic)
    places = _layered(list(by_pair))
    columns = sorted({x for x, _ in places.values()})
    for (publisher, subscriber), topics in by_pair.items():
        start, end = places[publisher], places[subscriber]
        spanned = columns.index(end[0]) - columns.index(start[0])
        bend = BEND * (spanned - 1) if start[1] == end[1] and spanned > 1 else 0.0  # bends around the nodes in between
        _arrow(axes, start, end, bend, shrink=34)
        x, y = (0.5 * (a + b) for a, b in zip(start, end, strict=True))
        lift = 0.5 * bend * (end[0] - start[0]) * ASPECT
        axes.text(x, y - lift + 0.02, "\n".join(sorted(topics)), fontsize=8.5, color=ACCENT, ha="center", va="bottom")
    for name, place in places.items():
        axes.text(*place, name, fontsize=10, color=INK, ha="center", va="center", bbox=BOX, zorder=3)
    save_figure(figure, path)
    return Figure(
        11, "The node map", "The simulator and the paper's chain as five processes, from rosapi.",
        "Theirs needs a ROS installation; ours connects the same nodes by a rosbridge alone.",
        columns=("publisher", "topic", "subscriber"), rows=[(e.publisher, e.topic, e.subscriber) for e in edges],
    )  # fmt: skip


def _draw_tree(axes: Axes, links: Sequence[Link], title: str) -> None:
    """Draw a tree from top to bottom, with the leaves side by side."""
    _bare(axes, title)
    children: dict[str, list[Link]] = {}
    for link in links:
        children.setdefault(link.parent, []).append(link)
    roots = [parent for parent in children if all(link.child != parent for link in links)]
    depth = max((_depth(children, root) for root in roots), default=1)
    leaves = sum(_leaves(children, root) for root in roots)
    taken = 0.0

    def put(frame: str, level: int) -> Place:
        nonlocal taken
        below = [(link, put(link.child, level + 1)) for link in children.get(frame, [])]
        if below:
            x = sum(place[0] for _, place in below) / len(below)
        else:
            x = (taken + 0.5) / leaves
            taken += 1.0
        here = x, 0.93 - 0.88 * level / max(depth, 1)
        for link, place in below:
            _arrow(axes, here, place)
            if link.rate_hz:
                axes.text(
                    0.5 * (x + place[0]), 0.5 * (here[1] + place[1]), f"{link.rate_hz:g} Hz", fontsize=8, color=ACCENT,
                    ha="center", va="center", bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
                )  # fmt: skip
        slant = 0 if leaves < 6 else 90 * (not below)
        axes.text(*here, frame, fontsize=8.5, color=INK, ha="center", va="top" if slant else "center", rotation=slant,
                  bbox=BOX, zorder=3)  # fmt: skip
        return here

    for root in roots:
        put(root, 0)


def _depth(children: dict[str, list[Link]], frame: str) -> int:
    return 1 + max((_depth(children, link.child) for link in children.get(frame, [])), default=-1)


def _leaves(children: dict[str, list[Link]], frame: str) -> int:
    return sum(_leaves(children, link.child) for link in children.get(frame, [])) or 1


def _layered(pairs: Sequence[tuple[str, str]]) -> dict[str, Place]:
    """Place nodes from left to right by the longest path to them from a source; nodes with equal paths are stacked."""
    names = list(dict.fromkeys(name for pair in pairs for name in pair))
    level = dict.fromkeys(names, 0)
    for _ in names:
        for publisher, subscriber in pairs:
            if (subscriber, publisher) not in pairs:
                level[subscriber] = max(level[subscriber], min(level[publisher] + 1, len(names)))
    places = {}
    for column in range(max(level.values(), default=0) + 1):
        inside = [name for name in names if level[name] == column]
        for row, name in enumerate(inside):
            x = 0.07 + 0.86 * column / max(*level.values(), 1)
            places[name] = x, 0.5 if len(inside) == 1 else 0.75 - 0.5 * row / (len(inside) - 1)
    return places


def _arrow(axes: Axes, start: Place, end: Place, bend: float = 0.0, shrink: float = 16.0) -> None:
    style = {
        "arrowstyle": "-|>", "color": FAINT_INK, "shrinkA": shrink, "shrinkB": shrink, "linewidth": 1.0,
        "connectionstyle": f"arc3,rad={bend}",
    }  # fmt: skip
    axes.annotate("", end, start, arrowprops=style)


def _bare(axes: Axes, title: str) -> None:
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold", color=INK)
