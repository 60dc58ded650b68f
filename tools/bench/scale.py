"""Time and memory against distance: one long survey, looked at every so many metres of track."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import matplotlib as mpl
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from uwsim import Simulator
from uwsim.mapping import OccupancyMap
from uwsim.survey.fly import fly_survey, required_survey

console = Console()


@dataclass(frozen=True)
class Look:
    """After track_m of track: wall time of the flight, memory of the process beyond what it had at its start."""

    track_m: float
    wall_s: float
    memory_mb: float


class Watcher:
    """Called at every ping; looks at clock and memory each time another every_m are flown."""

    def __init__(self, sim: Simulator, every_m: float) -> None:
        self._sim = sim
        self._every_m = every_m
        self._last_m = sim.rov.pose.position_world_m
        self._track_m = 0.0
        self._begun_s = time.perf_counter()
        self._begun_mb = resident_mb()
        self.looks = [Look(0.0, 0.0, 0.0)]

    def __call__(self, share: float) -> None:
        """Share flown, 0..1, is not needed."""
        here_m = self._sim.rov.pose.position_world_m
        self._track_m += float(np.linalg.norm(here_m - self._last_m))
        self._last_m = here_m
        if self._track_m >= self.looks[-1].track_m + self._every_m:
            self.look()

    def look(self) -> None:
        """Note how it stands."""
        wall_s = time.perf_counter() - self._begun_s
        self.looks.append(Look(self._track_m, wall_s, resident_mb() - self._begun_mb))


def main(
    scenario: Annotated[str, typer.Argument(help="A packaged scenario's name or the path of a YAML file.")] = (
        "reservoir"
    ),
    voxel: Annotated[float | None, typer.Option(help="Edge of a voxel [m]; the scenario's without.")] = None,
    mission_time: Annotated[float | None, typer.Option(help="Simulated seconds; the whole survey without.")] = None,
    every: Annotated[float, typer.Option(min=1.0, help="Metres of track between looks.")] = 500.0,
    threads: Annotated[int | None, typer.Option(help="Threads to use; all by default.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here too.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw time and memory against distance here (PNG).")] = None,
) -> None:
    """Fly one long survey and print time and memory against distance."""
    sim = Simulator(scenario, mission_time_s=mission_time, threads=threads)
    occupancy = OccupancyMap(voxel if voxel is not None else required_survey(sim.scenario).voxel_m)
    watcher = Watcher(sim, every)
    with console.status("flying"):
        _, record = fly_survey(sim, occupancy, on_progress=watcher)
    watcher.look()
    console.print(_table(watcher.looks, sim.scenario.name, occupancy.resolution_m, record.real_time_factor))
    console.print(f"ended because {record.stopped_because}; the map itself: {_map_mb(occupancy):.0f} MB")
    if json_file is not None:
        figures = {"real_time_factor": record.real_time_factor, "looks": [asdict(look) for look in watcher.looks]}
        json_file.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    if plot is not None:
        _draw(watcher.looks, plot)


def resident_mb() -> float:
    """Physical memory of this process now."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return float(status.split("VmRSS:")[1].split()[0]) / 1024.0


def _map_mb(occupancy: OccupancyMap) -> float:
    return occupancy.statistics().memory_bytes / 2**20


def _table(looks: list[Look], scenario: str, voxel_m: float, real_time_factor: float) -> Table:
    title = f"{scenario} at {voxel_m:g} m: {looks[-1].track_m / 1000:.1f} km, {real_time_factor:.1f} x real time"
    table = Table(title=title, title_justify="left")
    for column in ("track", "wall s", "s a km since", "memory MB", "MB a km since"):
        table.add_column(column, justify="right")
    for before, look in zip([looks[0], *looks[:-1]], looks, strict=True):
        km = max((look.track_m - before.track_m) / 1000.0, 1e-9)
        since = [f"{(look.wall_s - before.wall_s) / km:.1f}", f"{(look.memory_mb - before.memory_mb) / km:.0f}"]
        if look is before:
            since = ["", ""]
        table.add_row(f"{look.track_m:,.0f} m", f"{look.wall_s:.1f}", since[0], f"{look.memory_mb:.0f}", since[1])
    return table


def _draw(looks: list[Look], path: Path) -> None:
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    km = [look.track_m / 1000.0 for look in looks]
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7, 6), layout="constrained")
    above.plot(km, [look.wall_s for look in looks], marker=".")
    above.set_ylabel("wall time [s]")
    below.plot(km, [look.memory_mb for look in looks], marker=".")
    below.set(xlabel="track [km]", ylabel="memory since take-off [MB]")
    for axes in (above, below):
        axes.set_ylim(bottom=0)
        axes.grid(visible=True, alpha=0.3)
    figure.savefig(path, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    app = typer.Typer(add_completion=False)
    app.command()(main)
    app(prog_name="uwsim bench scale")
