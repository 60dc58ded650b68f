"""The history of the ratios that `python -m tools.history measure` has written."""

import io
import json
import math
from itertools import cycle
from typing import Any

import matplotlib
from tools.history import FOLDER, RATIOS, entries, machine_text

from uwsim.figures.style import ACCENT, FAINT_INK, INK, MISSED, new_figure

HEAD = """# Benchmark history

Ratios between uwsim and peers (Embree alone, Bullet, OctoMap), or between two of its own rates, measured in the same
rounds of one run and kept by commit in `docs/benchmarks`. Times depend on the machine and its load, ratios on the kind
of processor; each file states both. To add a commit, run `.venv/bin/python -m tools.history measure`; `compare OLD NEW`
builds two commits, measures them in turns on one machine, and prints how much better the new one is, with the spread of
the rounds. `check`, with which `.ci/run` ends, fails if a ratio has become much worse on its kind of processor.
[Performance](../inside/performance.md) has the absolute values.
"""


def benchmarks_page() -> str:
    """Return the page: a drawing with a panel per ratio, and a table of the newest commit."""
    kept = entries(FOLDER)
    if not kept:
        return HEAD
    newest = kept[-1]
    rows = [
        f"| {ratio.title} | {newest['ratios'][name]:.3g} | {'more' if ratio.more_is_better else 'less'} |"
        for name, ratio in RATIOS.items()
        if name in newest["ratios"]
    ]
    load = newest["load"]
    loaded = f"load {load['before']:g} before and {load['after']:g} after"
    where = f"{machine_text(newest['machine'])}, {loaded}"
    table = "\n".join([f"| {newest['commit'][:8]}, {where} | ratio | better is |", "|---|---|---|", *rows])
    return f"{HEAD}\n```{{raw}} html\n{drawing(kept)}\n```\n\n{table}\n"


def drawing(kept: list[dict[str, Any]]) -> str:
    """Return an SVG with a panel per ratio, over the commits; entries of one kind of machine are joined."""
    kinds = list({json.dumps(entry["machine"]): entry["machine"] for entry in kept}.values())
    rows = math.ceil(len(RATIOS) / 2)
    figure = new_figure(8.0, 1.8 * rows)
    panels = figure.subplots(rows, 2).ravel()
    commits = [entry["commit"][:8] for entry in kept]
    for panel, (name, ratio) in zip(panels, RATIOS.items(), strict=False):
        found = [(k, entry["ratios"][name]) for k, entry in enumerate(kept) if name in entry["ratios"]]
        for kind, colour in zip(kinds, cycle((FAINT_INK, ACCENT, INK, MISSED)), strict=False):
            places = [(k, value) for k, value in found if kept[k]["machine"] == kind]
            x, y = [k for k, _ in places], [value for _, value in places]
            panel.plot(x, y, "o-", color=colour, markersize=4, label=machine_text(kind))
        panel.set_title(ratio.title, loc="left", fontsize=7.5, color=INK)
        panel.set_ylim(0.0, 1.25 * max(value for _, value in found))
        panel.set_xlim(-0.5, len(commits) - 0.5)
        apart = 1 + (len(commits) - 1) // 5  # labels must not overlap
        panel.set_xticks(range(0, len(commits), apart), commits[::apart])
        panel.tick_params(labelsize=6.5, colors=INK)
    for panel in panels[len(RATIOS) :]:
        panel.remove()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncols=2, fontsize=7.5, frameon=False)
    figure.tight_layout(rect=(0.0, 0.03, 1.0, 1.0))
    text = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "uwsim"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]
