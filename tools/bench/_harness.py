"""Parts that benchmarks and soak tests share: rounds, ratios, tables with goals, worlds, native peers, processes."""

from __future__ import annotations

import ctypes
import gc
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from uwsim import Simulator, _core
from uwsim.scenario import Scenario, VehicleEntry, load
from uwsim.scenario.read.validated import validated

console = Console()
SWITCH_S = 0.0005  # as uwsim serve sets it
PACKET_BYTES = 580  # see native/embree_bare_rays.cpp

Rounds = Annotated[int, typer.Option(min=1, help="How often each case is measured; medians are reported.")]
PlotFile = Annotated[Path | None, typer.Option(help="Write this figure, a PNG. By default none is drawn.")]
"""The option of a benchmark that can draw what it has measured."""
Case = Callable[[], Any]


def alternated(cases: Mapping[Any, Case], rounds: int, *, warm_up: bool = False, what: str = "") -> dict[Any, Any]:
    """Measure all cases in each round, so that other load affects all of them equally; return each case's values.

    warm_up: precede the rounds by one that does not count. After the first round, the time that is left is shown, or
    printed once where there is no terminal.
    """
    found: dict[Any, list[Any]] = {name: [] for name in cases}
    begun_s, left = time.monotonic(), ""
    for turn in range(-warm_up, rounds):
        with console.status(f"{what}round {turn + 1} of {rounds}{left}"):
            for name, case in cases.items():
                value = case()
                if turn >= 0:
                    found[name].append(value)
        done, remaining = turn + warm_up + 1, rounds - turn - 1
        left_s = remaining * (time.monotonic() - begun_s) / done
        left = f", about {left_s:.0f} s left"
        if done == 1 and remaining and left_s > 5.0 and not console.is_terminal:
            console.print(f"{what}{rounds} rounds, about {left_s:.0f} s")
    return found


def medians(found: Mapping[Any, Iterable[float]]) -> dict[Any, float]:
    """Return the median of each case."""
    return {name: statistics.median(values) for name, values in found.items()}


def ratio(one: Iterable[float], other: Iterable[float]) -> float:
    """Return the median of the per-round ratios of two cases."""
    return statistics.median(a / b for a, b in zip(one, other, strict=True))


def spent_s(call: Case, clock: Callable[[], float] = time.process_time) -> float:
    """Return the time that a call takes."""
    begun = clock()
    call()
    return clock() - begun


def cores_used(call: Case) -> tuple[float, Any]:
    """Return this process's processor time per wall time during a call, and the call's result."""
    cpu_s, wall_s = time.process_time(), time.perf_counter()
    result = call()
    return (time.process_time() - cpu_s) / (time.perf_counter() - wall_s), result


def percentiles(values: Sequence[float], *which: int) -> dict[str, float]:
    """Return percentiles, p50 and so on; nan if there are no values."""
    return {f"p{p}": float(np.percentile(values, p)) if len(values) else float("nan") for p in which}


def readable(time_s: float) -> str:
    """Return a time with its unit."""
    return (
        f"{time_s:.3g} s" if time_s >= 1 else f"{1e3 * time_s:.3g} ms" if time_s >= 1e-3 else f"{1e6 * time_s:.3g} us"
    )


def new_table(title: str, *columns: str, texts: int = 1) -> Table:
    """Return a table whose first columns hold texts, and whose other columns hold numbers."""
    table = Table(title=title, title_justify="left")
    for k, column in enumerate(columns):
        table.add_column(column, justify="left" if k < texts else "right")
    return table


def goal_cells(value: float | None, goal: float | None, *, at_most: bool = False) -> tuple[str, str]:
    """Return a goal, and whether the value meets it; empty without either."""
    if value is None or goal is None:
        return "", ""
    met = value <= goal if at_most else value >= goal
    return f"{goal:,g}", "[green]yes[/]" if met else "[red]no[/]"


def show(title: str, results: Mapping[str, Any], goals: Mapping[str, str] | None = None) -> None:
    """Print values, and the goals of some, such as "<= 5" or ">= 0.9"."""
    table = new_table(title, "result", "measured", "goal", "met")
    for name, value in results.items():
        sign, limit = (goals or {}).get(name, " ").split(" ")
        text, met = goal_cells(value, float(limit) if limit else None, at_most=sign == "<=")
        table.add_row(escape(name), f"{value:.3g}" if abs(value) < 1e3 else f"{value:,.0f}", f"{sign} {text}", met)
    console.print(table)


def flat_water(vehicles: Sequence[dict[str, Any]], bed_depth_m: float = 20.0, **others: Any) -> Simulator:
    """Return water over a flat bed of 120 m x 120 m, still unless the scenario's other keys change it."""
    terrain = {"source": "noise", "size_m": [120, 120], "spacing_m": 1, "bed_depth_m": bed_depth_m, "hill_height_m": 0}
    rovs = [{"name": f"rov{k or ''}", **vehicle} for k, vehicle in enumerate(vehicles)]
    return Simulator(validated(Scenario, {"name": "bench", "terrain": terrain, "vehicles": rovs, **others}), threads=1)


def lake_fleet(starts_m: Sequence[Sequence[float]], model: str = "bluerov2_heavy", **changes: Any) -> Scenario:
    """Return the lake with these vehicles in place of its own."""
    fleet = tuple(
        VehicleEntry.model_validate({"name": f"rov{k or ''}", "model": model, "start": {"position_m": tuple(start)}})
        for k, start in enumerate(starts_m)
    )
    return load("lake").model_copy(update={"vehicles": fleet, **changes})


def native_program(name: str) -> Path | None:
    """Return the path of a native peer, which is installed with the compiled module; report one that is missing."""
    program = Path(_core.__file__).parent / "bench" / "native" / name
    if program.is_file():
        return program
    console.print(f"without {name}: not installed with the package (run tools/setup)")
    return None


class NativePeer:
    """A program that reads its input once, casts all rays at each request, and ends with this process."""

    def __init__(self, *command: object) -> None:
        self._process = subprocess.Popen(
            [str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        self._answers.readline()  # it is ready

    def times_s(self) -> list[float]:
        """Cast all rays; return the times that the program prints."""
        self._requests.write("\n")
        self._requests.flush()
        return [float(word) for word in self._answers.readline().split()]


def embree_alone(
    file: Path, world: _core.World, eye_m: Any, packets: bytes, threads: int, *faces: str
) -> NativePeer | None:
    """Return Embree alone, to cast a picture's ray packets, which start at `eye_m`; its times are wall and processor.

    faces: "quads" for a tree like our own, which is faster than one of triangles.
    """
    if (program := native_program("embree_bare_rays")) is None:
        return None
    vertices, triangles, _ = world.surface_mesh()
    with file.open("wb") as out:
        np.array([len(vertices), len(triangles), len(packets) // PACKET_BYTES], np.uint64).tofile(out)
        (vertices - eye_m).astype(np.float32).tofile(out)
        triangles.astype(np.uint32).tofile(out)
        out.write(packets)
    return NativePeer(program, file, threads, *faces)


def child(file: str, *arguments: object) -> subprocess.Popen[str]:
    """Start a benchmark's file as a separate process, which prints its results as JSON."""
    command = [sys.executable, file, *map(str, arguments)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def result_of(process: subprocess.Popen[str], limit_s: float | None = 300.0) -> Any:
    """Return the results of a process when it has ended."""
    return json.loads(process.communicate(timeout=limit_s)[0])


def ended(process: subprocess.Popen[Any]) -> None:
    """End a process now."""
    process.kill()
    process.communicate()


def wait_for(condition: Case, limit_s: float = 120.0) -> None:
    """Wait until a condition is true. Raises TimeoutError."""
    deadline_s = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > deadline_s:
            raise TimeoutError("the other processes did not come, or did not do what is measured")
        time.sleep(0.01)


def resident_mb(pid: int | str = "self") -> float:
    """Return the resident memory of a process in MB; of this one after a garbage collection."""
    if pid == "self":
        gc.collect()
    return 1e-6 * int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def trimmed_mb() -> float:
    """Return the resident memory in MB after the C library has returned its freed blocks, whose size varies."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return resident_mb()


def peak_mb() -> float:
    """Return the peak resident memory of this process in MB, since it began or was last reset."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1e-3 * 1.024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


@contextmanager
def station_page(scenario: str, reading_s: float = 0.0) -> Iterator[tuple[Any, Any, Any, dict[str, float]]]:
    """Open a station in Debian's headless Chromium, start the scenario and take the helm.

    Yield server, station, page, and what the start took. reading_s: the time at the start screen.
    """
    from playwright.sync_api import sync_playwright

    from uwsim.bridges import RosbridgeServer
    from uwsim.operator.station import Site, Station

    station = Station(offered=scenario)
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium-headless-shell", args=["--enable-unsafe-swiftshader"]
        )
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(server.url.replace("ws", "http", 1))
        wait_for(lambda: page.evaluate("Boolean(document.querySelector('#field-scenario'))"))
        first_paint_ms = page.evaluate("performance.getEntriesByName('first-paint')[0].startTime")
        time.sleep(reading_s)
        begun_s = time.perf_counter()
        page.click("button[type=submit]")
        # CSP forbids wait_for_function
        wait_for(lambda: page.evaluate("globalThis.station?.views.picture('front')?.drawn > 0"))
        start_s = time.perf_counter() - begun_s
        wait_for(lambda: page.evaluate("Boolean(station.station.isPilot)"))
        page.keyboard.press("r")
        yield server, station, page, {"first paint [s]": 1e-3 * first_paint_ms, "live after Start [s]": start_s}
        browser.close()
