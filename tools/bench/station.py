"""The operator's station without a browser: the server's cost, the data that it sends, and the latency of a key.

The lake runs in real time and is flown by this benchmark's own pilot in another process. Cases: no page; a page that
shows map and panel; the same with one view of 640 x 360 at 10 Hz; three pages, one of which never reads. The server's
CPU is that of this process, including simulator and map. Both processes use one clock. The latency of a key is the time
until the server confirms that it took effect. The latency of a picture is the time until its message is decoded,
measured both from the time when the picture is ready and from its simulated capture time.
"""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import time
from collections import defaultdict
from types import SimpleNamespace
from typing import Annotated, Any

import cbor2
import numpy as np
import typer
from _harness import child, console, goals_table, new_table, result_of, wait_for
from rich.table import Table
from websockets.asyncio.client import connect

from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.operator.station import Site, Station
from uwsim.simulator.simulator import Simulator

SWITCH_S = 0.0005  # as `uwsim station` sets it
VIEW = "/station/view/front"
PANEL = {
    "/station/state": {},
    "/telemetry": {"throttle_rate": 150},
    "/map_changes": {"throttle_rate": 250},
    "/ping": {"throttle_rate": 200},
}
GOALS = {
    "server without pictures [cores]": ("<=", 0.05),
    "map [kB/s]": ("<=", 10.0),
    "telemetry [kB/s]": ("<=", 5.0),
    "pictures [kB/s]": ("<=", 350.0),
    "pictures delivered": (">=", 0.9),
    "picture, ready to page, p50 [ms]": ("<=", 40.0),
    "picture, ready to page, p95 [ms]": ("<=", 200.0),
    "key to server p50 [ms]": ("<=", 20.0),
    "pace with three pages, one stalled": (">=", 0.95),
}


def main(
    seconds: Annotated[float, typer.Option(min=2.0, help="Length of each measurement [s].")] = 20.0,
    scenario: Annotated[str, typer.Option(help="The scenario that is flown.")] = "lake",
    browser: Annotated[bool, typer.Option("--browser", help="Then also measure in a browser (station_page).")] = False,
) -> dict[str, Any]:
    """Measure all cases in turn and print the results alongside their goals."""
    sys.setswitchinterval(SWITCH_S)
    cases = {}
    for name, pages in {
        "nobody": [],
        "a page": ["pilot"],
        "with a view": ["pilot view"],
        "three, one stalled": ["pilot view", "view", "stalled view"],
    }.items():
        console.print(f"[dim]{name}[/dim]")  # a spinner's thread would also be measured
        cases[name] = measure(scenario, pages, seconds)
    console.print(case_table(cases))
    results = against_goals(cases)
    console.print(goals_table("against the goals", results, GOALS))
    if browser:
        subprocess.run([sys.executable, "-m", "uwsim.cli.program", "bench", "station_page"], check=True)
    return {"cases": cases, "results": results}


def measure(scenario: str, pages: list[str], seconds: float) -> dict[str, Any]:
    """Run a station with pages, each in a separate process; return its cost and the data that the pages received."""
    station = Station()
    with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
        station.run(lambda: LiveSimulator(Simulator(scenario)))
        assert station.sessions.running is not None
        live = station.present().live
        ready_s = watch_pictures(station)
        live.rov.undock()
        crowd = [child(__file__, server.url, kind, seconds) for kind in pages]
        wait_for(lambda: len(server.sessions) == len(pages))
        time.sleep(1.0)
        began_s = time.monotonic() - live.simulator.time_s  # wall time at simulated time 0, if on pace
        slipped_s = live.slipped_s
        live.forget_delays()
        ready_s.clear()
        for process in crowd:
            assert process.stdin is not None
            process.stdin.write("\n")
            process.stdin.flush()
        cpu_s, wall_s, time_s = time.process_time(), time.perf_counter(), live.simulator.time_s
        time.sleep(seconds)
        cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - wall_s
        pace = (live.simulator.time_s - time_s) / wall_s
        found = [
            result_of(process) for process, kind in zip(crowd, pages, strict=True) if not kind.startswith("stalled")
        ]
        for process in crowd:
            process.kill()
        return {
            "cores": cpu_s / wall_s,
            "pace": pace,
            "late_ms": 1e3 * live.lateness,
            "slipped_s": live.slipped_s - slipped_s,
            "pages": [judged(page, ready_s, began_s) for page in found],
        }


def watch_pictures(station: Station) -> dict[int, float]:
    """Return the times [s] at which pictures were ready, by stamp [ns]. The dictionary is filled as pictures arrive."""
    assert station.sessions.running is not None
    views, ready_s = station.present().views, {}
    publish = views._node.publish

    def note(name: str, message: Any, time_ns: int = 0) -> None:
        if f"/{name}" == VIEW:
            ready_s[time_ns] = time.monotonic()
        publish(name, message, time_ns)

    views._node = SimpleNamespace(  # type: ignore[assignment]
        publish=note, is_wanted=views._node.is_wanted, is_awaited=views._node.is_awaited
    )
    return ready_s


def judged(page: dict[str, Any], ready_s: dict[int, float], began_s: float) -> dict[str, Any]:
    """Return a page's results, with the delays of its pictures."""
    came = [(stamp_ns, at_s) for stamp_ns, at_s in page.pop("pictures") if stamp_ns in ready_s]
    on_way_ms = [1e3 * (at_s - ready_s[stamp_ns]) for stamp_ns, at_s in came]
    shown_ms = [1e3 * (at_s - began_s) - 1e-6 * stamp_ns for stamp_ns, at_s in came]
    return {**page, "way_ms": percentiles(on_way_ms), "picture_ms": percentiles(shown_ms)}


async def be_page(url: str, kind: str, seconds: float) -> dict[str, Any]:
    """Act as a page: subscribe, draw immediately, and drive if it is the pilot."""
    sizes: dict[str, list[int]] = defaultdict(list)
    keys_ms: list[float] = []
    came: list[tuple[int, float]] = []
    answers: dict[str, float] = {}
    is_stalled = "stalled" in kind
    async with connect(url, compression=None, max_size=None, max_queue=1 if is_stalled else 64) as socket:
        topics = PANEL | ({VIEW: {"credit": 2}} if "view" in kind else {})
        for topic, options in topics.items():
            await socket.send(json.dumps({"op": "subscribe", "topic": topic, "compression": "cbor", **options}))
        await asyncio.to_thread(sys.stdin.readline)
        if is_stalled:
            await asyncio.sleep(3600)
        deadline_s = time.monotonic() + seconds

        async def call(service: str, **arguments: Any) -> None:
            answers[name := f"{service} {time.monotonic()}"] = time.monotonic()
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
                if name in answers and name.startswith("drive"):
                    keys_ms.append(1e3 * (time.monotonic() - answers.pop(name)))
                continue
            operation = cbor2.loads(frame)
            sizes[operation["topic"]].append(len(frame))
            if operation["topic"] == VIEW:
                stamp, now_s = operation["msg"]["header"]["stamp"], time.monotonic()
                came.append((stamp["secs"] * 10**9 + stamp["nsecs"], now_s))
                await socket.send(json.dumps({"op": "ack", "topic": VIEW}))
        if driving is not None:
            driving.cancel()
    return {
        "kb_per_s": {topic: 1e-3 * sum(lengths) / seconds for topic, lengths in sizes.items()},
        "per_s": {topic: len(lengths) / seconds for topic, lengths in sizes.items()},
        "largest_map_kb": 1e-3 * max(sizes.get("/map_changes", [0])),
        "key_ms": percentiles(keys_ms),
        "pictures": came,
    }


def percentiles(values: list[float]) -> dict[str, float]:
    """Return the median and the 95th percentile; nan if there are no values."""
    return {f"p{p}": float(np.percentile(values, p)) if values else float("nan") for p in (50, 95)}


def against_goals(cases: dict[str, Any]) -> dict[str, float]:
    """Return the values that have goals."""
    page, view = cases["a page"]["pages"][0], cases["with a view"]["pages"][0]
    return {
        "server without pictures [cores]": cases["a page"]["cores"],
        "map [kB/s]": page["kb_per_s"].get("/map_changes", 0.0),
        "telemetry [kB/s]": page["kb_per_s"].get("/telemetry", 0.0),
        "pictures [kB/s]": view["kb_per_s"].get(VIEW, 0.0),
        "pictures delivered": view["per_s"].get(VIEW, 0.0) / 10.0,
        "picture, ready to page, p50 [ms]": view["way_ms"]["p50"],
        "picture, ready to page, p95 [ms]": view["way_ms"]["p95"],
        "key to server p50 [ms]": page["key_ms"]["p50"],
        "pace with three pages, one stalled": cases["three, one stalled"]["pace"],
    }


def case_table(cases: dict[str, Any]) -> Table:
    """Return the table of cases."""
    columns = ("pages", "cores", "pace", "late [ms]", "slipped [s]", "key p50, p95 [ms]", "pictures/s", "p50, p95 [ms]")
    title = "the station in real time: CPU of simulator, map, server and pictures together"
    table = new_table(title, *columns, texts=0)
    for name, case in cases.items():
        keys = [f"{p['key_ms']['p50']:.1f}, {p['key_ms']['p95']:.1f}" for p in case["pages"] if p["key_ms"]["p50"] > 0]
        shown = [p for p in case["pages"] if VIEW in p["per_s"]]
        table.add_row(
            name, f"{case['cores']:.3f}", f"{case['pace']:.3f}", f"{case['late_ms']:.1f}", f"{case['slipped_s']:.2f}",
            ", ".join(keys), ", ".join(f"{p['per_s'][VIEW]:.1f}" for p in shown),
            "; ".join(f"{p['picture_ms']['p50']:.0f}, {p['picture_ms']['p95']:.0f}" for p in shown),
        )  # fmt: skip
    return table


if __name__ == "__main__":
    url, kind, seconds = sys.argv[1:]
    print(json.dumps(asyncio.run(be_page(url, kind, float(seconds)))))
