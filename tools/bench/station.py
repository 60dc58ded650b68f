"""The operator's station: the server's cost, the data that it sends, and the latency of keys and pictures.

The lake runs in real time and is flown by this benchmark's own pilot in another process, by the same clock. The CPU is
that of this process, including simulator and map. A key's latency ends when the server confirms that it took effect, a
picture's when its message is decoded or, with --browser, when it is on the canvas of a headless Chromium that draws
WebGL in software on the same cores (tools/setup --dev).
"""

from __future__ import annotations

import asyncio
import json
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any

import cbor2
import numpy as np
import typer
from _harness import (
    SWITCH_S,
    child,
    console,
    cores_used,
    ended,
    percentiles,
    result_of,
    show,
    spent_s,
    station_page,
    wait_for,
)
from websockets.asyncio.client import connect

from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.operator.station import Site, Station
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from playwright.sync_api import Page

VIEW, PICTURES_HZ = "/station/view/front", 10.0
PANEL = {
    "/station/state": {},
    "/telemetry": {"throttle_rate": 150},
    "/map_changes": {"throttle_rate": 250},
    "/ping": {"throttle_rate": 200},
}
CASES = {
    "no page": [],
    "a page": ["pilot"],
    "with a view": ["pilot view"],
    "three, one stalled": ["pilot view", "view", "stalled view"],
}
GOALS = {
    "a page: cores": "<= 0.05",
    "a page: /map_changes [kB/s]": "<= 10",
    "a page: /telemetry [kB/s]": "<= 5",
    f"with a view: {VIEW} [kB/s]": "<= 350",
    "with a view: pictures delivered": ">= 0.9",
    "with a view: picture, ready to page p50 [ms]": "<= 40",
    "with a view: picture, ready to page p95 [ms]": "<= 200",
    "a page: key to server p50 [ms]": "<= 20",
    "three, one stalled: pace": ">= 0.95",
}
PAGE_GOALS = {
    "first paint [s]": "<= 0.3",
    "live after Start [s]": "<= 1",
    "orbiting the surveyed lake [frames/s]": ">= 5",
    "pictures delivered": ">= 0.9",
    "picture, server to canvas p50 [ms]": "<= 40",
    "picture, server to canvas p95 [ms]": "<= 200",
    "key to server and back p50 [ms]": "<= 20",
}
EDGE, OCCUPIED = 16, 0x8000  # voxels per block along an axis; the bit of an occupied voxel


def main(
    seconds: Annotated[float, typer.Option(min=2.0, help="Length of each measurement [s].")] = 20.0,
    scenario: Annotated[str, typer.Option(help="The scenario that is flown.")] = "lake",
    browser: Annotated[bool, typer.Option("--browser", help="Then also measure in a browser.")] = False,
) -> dict[str, Any]:
    """Measure all cases in turn and print the results alongside their goals."""
    sys.setswitchinterval(SWITCH_S)
    results: dict[str, Any] = {}
    for name, pages in CASES.items():
        console.print(f"[dim]{name}[/dim]")  # a spinner's thread would also be measured
        results |= {f"{name}: {key}": value for key, value in measure(scenario, pages, seconds).items()}
    show("the station in real time: CPU of simulator, map, server and pictures together", results, GOALS)
    if browser:
        found = in_browser(seconds, scenario)
        show("in a browser, software GL", found, PAGE_GOALS)
        results["browser"] = found
    return results


def measure(scenario: str, pages: list[str], seconds: float) -> dict[str, float]:
    """Run a station with pages, each in a separate process; return its cost, and the first page's data."""
    station = Station()
    with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
        station.run(lambda: LiveSimulator(Simulator(scenario)))
        live = station.present().live
        ready_s = watch_pictures(station, time.monotonic)
        live.rov.undock()
        crowd = [child(__file__, server.url, kind, seconds) for kind in pages]
        wait_for(lambda: len(server.sessions) == len(pages))
        time.sleep(1.0)
        live.forget_delays()
        ready_s.clear()
        for process in crowd:
            assert process.stdin is not None
            process.stdin.write("\n")
            process.stdin.flush()
        from_s, begun_s = live.simulator.time_s, time.perf_counter()
        cores, _ = cores_used(lambda: time.sleep(seconds))
        pace = (live.simulator.time_s - from_s) / (time.perf_counter() - begun_s)
        found = {"cores": cores, "pace": pace, "late [ms]": 1e3 * live.lateness}
        for process, kind in list(zip(crowd, pages, strict=True))[:1]:
            page = result_of(process)
            found |= {f"{topic} [kB/s]": 1e-3 * sum(sizes) / seconds for topic, sizes in page["sizes"].items()}
            found |= named("key to server", page["keys_ms"])
            if "view" in kind:
                found["pictures delivered"] = len(page["sizes"].get(VIEW, ())) / (PICTURES_HZ * seconds)
                way_ms = [1e3 * (at_s - ready_s[ns]) for ns, at_s in page["pictures"] if ns in ready_s]
                found |= named("picture, ready to page", way_ms)
        for process in crowd:
            ended(process)
        return found


def named(what: str, times_ms: Any) -> dict[str, float]:
    """Return the median and the 95th percentile of some times."""
    return {f"{what} {name} [ms]": value for name, value in percentiles(times_ms, 50, 95).items()}


def watch_pictures(station: Station, clock: Any) -> dict[int, float]:
    """Return the times [s] at which pictures were ready, by stamp [ns]. The dictionary is filled as pictures arrive."""
    views, ready_s = station.present().views, {}
    node = views._node

    def note(name: str, message: Any, time_ns: int = 0) -> None:
        if f"/{name}" == VIEW:
            ready_s[time_ns] = clock()
        node.publish(name, message, time_ns)

    views._node = SimpleNamespace(publish=note, is_wanted=node.is_wanted, is_awaited=node.is_awaited)
    return ready_s


async def be_page(url: str, kind: str, seconds: float) -> dict[str, Any]:
    """Act as a page: subscribe, draw immediately, and drive if it is the pilot."""
    sizes: dict[str, list[int]] = defaultdict(list)
    keys_ms: list[float] = []
    came: list[tuple[int, float]] = []
    asked_s: dict[str, float] = {}
    is_stalled = "stalled" in kind
    async with connect(url, compression=None, max_size=None, max_queue=1 if is_stalled else 64) as socket:
        for topic, options in (PANEL | ({VIEW: {"credit": 2}} if "view" in kind else {})).items():
            await socket.send(json.dumps({"op": "subscribe", "topic": topic, "compression": "cbor", **options}))
        await asyncio.to_thread(sys.stdin.readline)
        if is_stalled:
            await asyncio.sleep(3600)
        deadline_s = time.monotonic() + seconds

        async def call(service: str, **arguments: Any) -> None:
            asked_s[name := f"{service} {time.monotonic()}"] = time.monotonic()
            call = {"op": "call_service", "service": f"/station/{service}", "args": arguments, "id": name}
            await socket.send(json.dumps(call))

        async def drive() -> None:
            await call("join", name="pilot")
            await call("take_control")
            while True:
                await call("drive", vehicle="rov", surge=0.8, yaw=0.02, stamp_ms=1e3 * time.monotonic())
                await asyncio.sleep(0.2)

        driving = asyncio.create_task(drive()) if "pilot" in kind else None
        while (left_s := deadline_s - time.monotonic()) > 0:
            try:
                frame = await asyncio.wait_for(socket.recv(), left_s)
            except TimeoutError:
                break
            if isinstance(frame, str):
                name = json.loads(frame).get("id")
                if name in asked_s and name.startswith("drive"):
                    keys_ms.append(1e3 * (time.monotonic() - asked_s.pop(name)))
                continue
            operation = cbor2.loads(frame)
            sizes[operation["topic"]].append(len(frame))
            if operation["topic"] == VIEW:
                stamp, now_s = operation["msg"]["header"]["stamp"], time.monotonic()
                came.append((stamp["secs"] * 10**9 + stamp["nsecs"], now_s))
                await socket.send(json.dumps({"op": "ack", "topic": VIEW}))
        if driving is not None:
            driving.cancel()
    return {"sizes": sizes, "keys_ms": keys_ms, "pictures": came}


def in_browser(seconds: float, scenario: str) -> dict[str, float]:
    """Start from the start screen, fly, and rotate the map of a survey; return all values."""
    from uwsim.flight.survey import run_survey

    with tempfile.TemporaryDirectory() as folder:
        with console.status("surveying"):
            run_survey(scenario, Path(folder) / "survey", report="none")
        changes = map_changes(Path(folder) / "survey" / "map.bt")
    with station_page(scenario, reading_s=5.0) as (_, station, page, results):
        page.keyboard.down("w")
        with console.status("flying"):
            results |= flying(page, station, seconds)
        page.keyboard.up("w")
        with console.status("orbiting"):
            results |= orbiting(page, changes, seconds)
    return results


def flying(page: Page, station: Station, seconds: float) -> dict[str, float]:
    """Watch the front camera while a key is held down."""
    live, ready_s = station.present().live, watch_pictures(station, time.time)
    time.sleep(2.0)
    # The time when simulated time was 0, by the clock that the page uses for time stamps: the earliest of many
    # readings, because readings are delayed.
    began_s = min(live.read(lambda sim: time.time() - sim.time_s).result() for _ in range(50))
    before = page.evaluate("station.views.picture('front').drawn")
    wall_s = spent_s(lambda: time.sleep(seconds), time.perf_counter)
    drawn = page.evaluate("station.views.picture('front').drawn") - before
    shown = page.evaluate("station.views.picture('front').shown")[-drawn:]
    ready_ms = {round(1e-6 * ns): 1e3 * at_s for ns, at_s in ready_s.items()}
    return {
        "pictures delivered": drawn / (PICTURES_HZ * wall_s),
        **named("picture, server to canvas", [at_ms - ready_ms[round(1e3 * time_s)] for time_s, _, at_ms in shown]),
        **named("picture, capture to canvas", [at_ms - 1e3 * (began_s + time_s) for time_s, _, at_ms in shown]),
        "key to server and back p50 [ms]": float(np.median(page.evaluate("station.pilot.answers_ms"))),
        "pace": live.factor,
    }


def orbiting(page: Page, changes: dict[str, Any], seconds: float) -> dict[str, float]:
    """Rotate the 3D camera about the whole map while pictures and telemetry arrive."""
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
      return 1000 * (scene.gate.frames - frames) / (performance.now() - began);
    }"""
    page.evaluate(turn, 5.0)  # until the level of detail has settled
    return {"orbiting the surveyed lake [frames/s]": page.evaluate(turn, seconds)}


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


if __name__ == "__main__":
    url, kind, seconds = sys.argv[1:]
    print(json.dumps(asyncio.run(be_page(url, kind, float(seconds)))))
