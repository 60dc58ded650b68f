"""The transform tree, drawn from a running system's data (Fig. 10)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes

from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.running_system import Link
from uwsim.figures.style import ACCENT, FAINT_INK, INK, new_figure, save_figure

Place = tuple[float, float]
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


def _arrow(axes: Axes, start: Place, end: Place) -> None:
    style = {"arrowstyle": "-|>", "color": FAINT_INK, "shrinkA": 16.0, "shrinkB": 16.0, "linewidth": 1.0}
    axes.annotate("", end, start, arrowprops=style)


def _bare(axes: Axes, title: str) -> None:
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold", color=INK)
