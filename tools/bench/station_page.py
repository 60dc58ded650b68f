"""The operator's station in a browser: its loading time, its frame rate and the growth of its memory.

Debian's headless Chromium draws WebGL in software, like a laptop without a GPU, on the same cores as the simulator. A
picture's latency is the time until it is on the canvas, measured both from the time when the server has the picture and
from its simulated capture time; the latter includes rendering and compression. It needs the development installation
(tools/setup --dev). `uwsim bench station` measures the server without a browser.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import numpy as np
import typer
from _harness import console, goals_table
from playwright.sync_api import CDPSession, Page, sync_playwright

from uwsim.bridges import RosbridgeServer
from uwsim.flight.survey import run_survey
from uwsim.mapping import OccupancyMap
from uwsim.operator.station import Site, Station

SWITCH_S = 0.0005  # as `uwsim station` sets it
CHROMIUM = "/usr/bin/chromium-headless-shell"
SIZE = {"width": 1440, "height": 900}
EDGE = 16  # voxels per block along an axis
OCCUPIED = 0x8000
GOALS = {
    "first paint [s]": ("<=", 0.3),
    "live after Start [s]": ("<=", 1.0),
    "orbiting the surveyed lake [frames/s]": (">=", 5.0),
    "pictures delivered": (">=", 0.9),
    "picture, server to canvas p50 [ms]": ("<=", 40.0),
    "picture, server to canvas p95 [ms]": ("<=", 200.0),
    "key to server and back p50 [ms]": ("<=", 20.0),
    "pace at 10 times": (">=", 8.0),
    "heap growth [MB/h]": ("<=", 20.0),
}


def main(
    seconds: Annotated[float, typer.Option(min=2.0, help="Length of each measurement [s].")] = 20.0,
    heap_minutes: Annotated[
        float, typer.Option(min=0.0, help="How long the heap is watched in flight; 5 show a trend, 0: not at all.")
    ] = 0.0,
    reading_s: Annotated[float, typer.Option(min=0.0, help="Time at the start screen, before Start [s].")] = 5.0,
    surveyed: Annotated[Path | None, typer.Option("--map", help="A .bt to orbit. Default: the lake's survey.")] = None,
) -> dict[str, Any]:
    """Measure in a browser and print the values with their goals."""
    sys.setswitchinterval(SWITCH_S)
    with tempfile.TemporaryDirectory() as folder:
        if surveyed is None:
            with console.status("surveying the lake"):
                run_survey("lake", Path(folder) / "survey", report="none")
            surveyed = Path(folder) / "survey" / "map.bt"
        results = measure(surveyed, seconds, heap_minutes, reading_s)
    console.print(goals_table("the station in a browser, software GL", results, GOALS))
    return results


def measure(surveyed: Path, seconds: float, heap_minutes: float, reading_s: float) -> dict[str, float]:
    """Start a lake from the start screen, fly it, and rotate the map; return all values."""
    station = Station(offered="lake")
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--enable-unsafe-swiftshader"])
        page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
        page.goto(server.url.replace("ws", "http", 1))
        until(page, "document.querySelector('#field-scenario')")
        results = {"first paint [s]": 1e-3 * page.evaluate("performance.getEntriesByName('first-paint')[0].startTime")}
        with console.status("reading the start screen"):
            time.sleep(reading_s)
        with console.status("starting"):
            begun = time.perf_counter()
            page.click("button[type=submit]")
            until(page, "globalThis.station.views.picture('front')?.drawn > 0")
            results["live after Start [s]"] = time.perf_counter() - begun
        until(page, "station.station.isPilot")
        page.keyboard.press("r")
        page.keyboard.down("w")
        with console.status("flying"):
            results |= flying(page, station, seconds)
        with console.status("flying 10 times as fast"):
            results["pace at 10 times"] = pace_at(station, 10.0, seconds)
        if heap_minutes:
            with console.status("watching the heap"):
                results["heap growth [MB/h]"] = heap_growth(page, heap_minutes)
        page.keyboard.up("w")
        with console.status("orbiting"):
            results |= orbiting(page, surveyed, seconds)
        browser.close()
    return results


def flying(page: Page, station: Station, seconds: float) -> dict[str, float]:
    """Watch the front camera while a key is held down."""
    live, ready_s = station.present().live, watch_pictures(station)
    time.sleep(2.0)
    # The time when simulated time was 0, by the clock that the page uses for time stamps: the earliest of many
    # readings, because readings are delayed.
    began_s = min(live.read(lambda sim: time.time() - sim.time_s).result() for _ in range(50))
    drawn, taken = page.evaluate("station.views.picture('front').drawn"), page.evaluate("station.station.bridge.bytes")
    begun = time.perf_counter()
    time.sleep(seconds)
    wall_s = time.perf_counter() - begun
    drawn = page.evaluate("station.views.picture('front').drawn") - drawn
    shown = page.evaluate("station.views.picture('front').shown")[-drawn:]
    on_way_ms = [drawn_ms - 1e3 * ready_s[round(1e3 * moment_s)] for moment_s, _, drawn_ms in shown]
    late_ms = [drawn_ms - 1e3 * (began_s + moment_s) for moment_s, _, drawn_ms in shown]
    return {
        "pictures delivered": drawn / (10.0 * wall_s),
        "picture, server to canvas p50 [ms]": float(np.percentile(on_way_ms, 50)),
        "picture, server to canvas p95 [ms]": float(np.percentile(on_way_ms, 95)),
        "picture, moment to canvas p50 [ms]": float(np.percentile(late_ms, 50)),
        "picture, moment to canvas p95 [ms]": float(np.percentile(late_ms, 95)),
        "picture's width": page.evaluate("station.views.picture('front').canvas.width"),
        "key to server and back p50 [ms]": float(np.median(page.evaluate("station.pilot.answers_ms"))),
        "whole page [kB/s]": 1e-3 * (page.evaluate("station.station.bridge.bytes") - taken) / wall_s,
        "pace": live.factor,
    }


def pace_at(station: Station, speed: float, seconds: float) -> float:
    """Return the simulated seconds per second while this many are asked for, with the page open."""
    live = station.present().live
    live.speed = speed
    time.sleep(3.0)
    begun, from_s = time.perf_counter(), live.simulator.time_s
    time.sleep(seconds)
    pace = (live.simulator.time_s - from_s) / (time.perf_counter() - begun)
    live.speed = 1.0
    return pace


def watch_pictures(station: Station) -> dict[int, float]:
    """Return the times [s] at which pictures of the front camera were ready, by capture time [ms]."""
    views, ready_s = station.present().views, {}
    node = views._node

    def note(name: str, message: Any, time_ns: int = 0) -> None:
        if name == "station/view/front":
            ready_s[round(1e-6 * time_ns)] = time.time()
        node.publish(name, message, time_ns)

    views._node = SimpleNamespace(publish=note, is_wanted=node.is_wanted, is_awaited=node.is_awaited)
    return ready_s


def orbiting(page: Page, surveyed: Path, seconds: float) -> dict[str, float]:
    """Rotate the 3D camera about the whole map while pictures and telemetry arrive."""
    changes = map_changes(surveyed)
    page.evaluate(
        """({resolution, blocks, counts, cells}) => {
          const {views, scene} = globalThis.station;
          views.enlarge('scene');
          scene.showMap({snapshot: true, sequence: 0, resolution, blocks: Int16Array.from(blocks),
            counts: Uint16Array.from(counts), cells: Uint16Array.from(cells)});
          scene.tools.querySelector('[data-layer=follows]').click(); // follow no longer
          scene.controls.target.set(-24, -28, -30);
          scene.camera.position.set(-24, -190, 70);
        }""",
        changes,
    )
    turn = """async (seconds) => {
      const {scene} = globalThis.station;
      const [end, frames, began] = [performance.now() + 1000 * seconds, scene.gate.frames, performance.now()];
      scene.isOrbiting = true;
      while (performance.now() < end) {
        await new Promise((done) => requestAnimationFrame(done));
        scene.camera.position.applyAxisAngle({x: 0, y: 0, z: 1}, 0.01);
        scene.controls.update();
      }
      scene.isOrbiting = false;
      return {fps: 1000 * (scene.gate.frames - frames) / (performance.now() - began), drawn: scene.voxels.pointCount,
        known: scene.store.count, step: scene.quality.step};
    }"""
    page.evaluate(turn, 5.0)  # until the level of detail has settled
    found = page.evaluate(turn, seconds)
    return {
        "orbiting the surveyed lake [frames/s]": found["fps"],
        "voxels known": found["known"],
        "points drawn": found["drawn"],
        "step of quality (0: finest)": found["step"],
    }


def map_changes(path: Path) -> dict[str, Any]:
    """Return a map as a single uwsim_msgs/MapChanges message."""
    known = OccupancyMap.read(path)
    voxels = np.unique(np.floor(known.occupied_voxels()[:, :3] / known.resolution_m).astype(np.int64), axis=0)
    blocks, inverse, counts = np.unique(voxels // EDGE, axis=0, return_inverse=True, return_counts=True)
    inside = voxels % EDGE
    cells = OCCUPIED | inside[:, 0] | inside[:, 1] << 4 | inside[:, 2] << 8
    return {
        "resolution": known.resolution_m,
        "blocks": blocks.ravel().tolist(),
        "counts": counts.tolist(),
        "cells": cells[np.argsort(inverse.ravel(), kind="stable")].tolist(),
    }


def heap_growth(page: Page, minutes: float) -> float:
    """Return the growth rate of the page's memory, excluding garbage [MB/h]."""
    session = page.context.new_cdp_session(page)
    time.sleep(5.0)
    first, begun = heap_mb(session), time.perf_counter()
    time.sleep(60.0 * minutes)
    return (heap_mb(session) - first) / (time.perf_counter() - begun) * 3600.0


def heap_mb(session: CDPSession) -> float:
    """Return the size of the live objects in a page's heap [MB]."""
    session.send("HeapProfiler.collectGarbage")
    used: float = session.send("Runtime.getHeapUsage")["usedSize"]
    return 1e-6 * used


def until(page: Page, expression: str, limit_s: float = 120.0) -> None:
    """Wait until a JavaScript expression is true in the page."""
    deadline_s = time.monotonic() + limit_s
    while not page.evaluate(f"Boolean({expression})"):
        if time.monotonic() > deadline_s:
            raise TimeoutError(f"waited in vain for {expression}")
        time.sleep(0.01)
