"""Soak test: the operator's station, flown in a browser for an hour, does not leak memory.

    .venv/bin/python tools/soak/station.py [--minutes 60] [--json FILE]

One page with pictures, sonar and the growing map drives the lake's vehicle, straight ahead and in turns. One line is
printed every minute, after a garbage collection: the page's heap, resident memory of the page's process and of the
server, voxels of the map, commands in the server's log, and the pace. Map, track and log grow because the vehicle
flies; caches fill in the first minutes, which are ignored.

The exit code is 1 if a straight line through the samples of the page's heap rises by more than 20 MB per hour.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving
from uwsim.operator.station import Site, Station

CHROMIUM = "/usr/bin/chromium-headless-shell"
GROWTH_MB_PER_H = 20.0
SETTLING_MIN = 5.0
ASTERN_S, TURN_S = 6.0, 9.0  # of each minute


def main() -> int:
    """Fly; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--json", type=Path, help="also write the samples to this file")
    options = parser.parse_args()
    if options.minutes <= SETTLING_MIN + 1.0:
        parser.error(f"--minutes {options.minutes:g}: must be more than {SETTLING_MIN + 1.0:g}")
    keep_threads_moving()
    station = Station(offered="lake")
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--enable-unsafe-swiftshader"])
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(server.url.replace("ws", "http", 1))
        page.click("button[type=submit]")
        while not page.evaluate("Boolean(globalThis.station?.station.isPilot)"):  # CSP forbids wait_for_function
            time.sleep(0.1)
        page.keyboard.press("r")
        samples = fly(browser, page, station, options.minutes)
        browser.close()
    if options.json is not None:
        options.json.write_text(json.dumps(samples, indent=1) + "\n", encoding="utf-8")
    heap = growth_mb_per_h(samples, "heap_mb")
    print(
        f"after the first {SETTLING_MIN:g} min, per hour: page's heap {heap:+.1f} MB (at most {GROWTH_MB_PER_H:g}), "
        f"its process {growth_mb_per_h(samples, 'page_rss_mb'):+.1f} MB, "
        f"server {growth_mb_per_h(samples, 'server_rss_mb'):+.1f} MB"
    )
    return int(not heap <= GROWTH_MB_PER_H)


def fly(browser: Browser, page: Page, station: Station, minutes: float) -> list[dict[str, float]]:
    """Drive astern, turn and go ahead in each minute; return one sample per minute."""
    session, processes = page.context.new_cdp_session(page), browser.new_browser_cdp_session()
    samples = []
    begun = time.monotonic()
    for minute in range(1, round(minutes) + 1):
        hold(page, "s", ASTERN_S)  # away from any obstacle it has hit
        hold(page, "q" if minute % 3 else "e", TURN_S)
        hold(page, "w", begun + 60.0 * minute - time.monotonic())
        samples.append({"min": (time.monotonic() - begun) / 60.0, **sample(session, processes, page, station)})
        print("  ".join(f"{name} {value:.4g}" for name, value in samples[-1].items()), flush=True)
    return samples


def hold(page: Page, key: str, seconds: float) -> None:
    """Hold a key down."""
    page.keyboard.down(key)
    time.sleep(max(seconds, 0.0))
    page.keyboard.up(key)


def sample(session: CDPSession, processes: CDPSession, page: Page, station: Station) -> dict[str, float]:
    """Return the memory in use now, after a garbage collection."""
    session.send("HeapProfiler.collectGarbage")
    gc.collect()
    live = station.present().live
    found = page.evaluate("({voxels: station.scene.store.count, drawn: station.views.picture('front').drawn})")
    return {
        "heap_mb": 1e-6 * session.send("Runtime.getHeapUsage")["usedSize"],
        "page_rss_mb": page_process_mb(processes),
        "server_rss_mb": resident_mb(os.getpid()),
        "voxels": found["voxels"],
        "pictures": found["drawn"],
        "commands": len(list(live.log)),
        "pace": live.factor,
    }


def page_process_mb(processes: CDPSession) -> float:
    """Return the memory of the browser's processes that run pages."""
    info: list[dict[str, Any]] = processes.send("SystemInfo.getProcessInfo")["processInfo"]
    return sum(resident_mb(process["id"]) for process in info if process["type"] == "renderer")


def resident_mb(pid: int) -> float:
    """Return a process's resident memory in MB."""
    return 1e-6 * int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def growth_mb_per_h(samples: list[dict[str, float]], name: str) -> float:
    """Return the slope of a straight line through the samples after the first minutes."""
    kept = [(each["min"] / 60.0, each[name]) for each in samples if each["min"] > SETTLING_MIN]
    hours, values_mb = np.array(kept).T
    return float(np.polyfit(hours, values_mb, 1)[0])


if __name__ == "__main__":
    sys.exit(main())
