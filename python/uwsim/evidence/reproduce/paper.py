"""Draws all figures, and writes a table of their values and a page that displays them."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.folder_lock import alone_in
from uwsim.evidence.reproduce import graphs, movement_and_ray, mown_map, scenes, screens, sonar
from uwsim.evidence.reproduce.figure import PAPER, Figure
from uwsim.figures.html_page import data_uri, filled_page
from uwsim.scenario import Scenario, load
from uwsim.simulator.simulator import Simulator

TEMPLATE = Path(__file__).with_name("page.html.j2")


def reproduce_paper(out: Path, progress: Callable[[str], object] = lambda text: None) -> list[Figure]:
    """Write Figs. 1 to 12 as fig01.png to fig12.png, figures.json with their values, and index.html. Raises OSError.

    progress: called with a one-line message about each finished file. Pictures and values are the same in every run,
    except for the screens, which come from a live simulator (see `screens`).
    """
    out.mkdir(parents=True, exist_ok=True)
    with alone_in(out):
        return _make_all(out, progress)


def _make_all(out: Path, progress: Callable[[str], object]) -> list[Figure]:
    began_s = time.monotonic()
    figures: list[Figure] = []

    def add(figure: Figure) -> None:
        figures.append(figure)
        progress(f"{figure.name}.png  {figure.title}  ({time.monotonic() - began_s:.0f} s)")

    draw(Subject(load("paper")), out, add)
    add(sonar.coverage(out / "fig08.png"))
    add(mown_map.mown_map(out / "fig12.png", out / "map.bt"))
    figures.sort(key=lambda figure: figure.number)
    table = json.dumps([plain(asdict(figure)) for figure in figures], indent=1, allow_nan=False)
    write_atomically(out / "figures.json", (table + "\n").encode())
    write_atomically(out / "index.html", _page(figures, out).encode())
    progress(f"index.html, figures.json, map.bt  ({time.monotonic() - began_s:.0f} s)")
    return figures


@dataclass(frozen=True, eq=False)
class Subject:
    """The world that the figures show, and where they are taken; by default those of `paper`.

    offered: the scenario's name or path for the station's page. gate: the name of the gate of Fig. 7. size: of the
    vehicle in Fig. 3, relative to that of `paper`.
    """

    scenario: Scenario
    offered: str = "paper"
    before_the_gate: scenes.Place = scenes.BEFORE_THE_GATE
    over_the_pipeline: scenes.Place = screens.OVER_THE_PIPELINE
    gate: str = movement_and_ray.TARGET
    size: float = 1.0


def draw(subject: Subject, out: Path, add: Callable[[Figure], object]) -> None:
    """Draw the figures that show a world, all but the table of Fig. 8 and the map of Fig. 12, into a folder."""
    cameras = {"overview": scenes.OVERVIEW, "beside": sonar.BESIDE}
    sim = Simulator(scenes.with_cameras(subject.scenario, **cameras))
    add(graphs.transform_tree(sim, out / "fig10.png"))
    add(graphs.node_map(sim, out / "fig11.png"))
    add(scenes.overview(sim, out / "fig01.png"))
    add(scenes.scene(sim, out / "fig02.png", subject.before_the_gate))
    add(movement_and_ray.movements(sim, out / "fig03.png", subject.size))
    for figure in screens.screens(sim, out, subject.offered, subject.over_the_pipeline):
        add(figure)
    add(sonar.depth_image(sim, out / "fig06.png", subject.before_the_gate))
    add(movement_and_ray.ray(sim, out / "fig07.png", subject.gate))
    add(sonar.ping(sim, out / "fig09.png"))


def _page(figures: list[Figure], out: Path) -> str:
    shown = [
        (figure, data_uri(out / f"{figure.name}.png"), [list(map(_shown, row)) for row in figure.rows])
        for figure in figures
    ]
    return filled_page(TEMPLATE, paper=PAPER, figures=shown, shown=_shown)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def plain(value: Any) -> Any:
    """Return JSON values; non-finite numbers, such as a range without an echo, become None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
