"""Soak test: a page that starts a simulator keeps the controls, in hundreds of starts.

    .venv/bin/python tools/soak/starts.py [--starts 200] [--flown 2] [--scenarios lake,pool] [--json FILE]

A page presses Start, flies ahead for some seconds, and returns to the start screen. Each fifth start is in a new page.
The exit code is 1 if a page lost its connection or the controls.
"""

from __future__ import annotations

import argparse
import itertools
import json
import logging
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

from steady import verdict

from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving
from uwsim.operator.station import Site, Station

PAGES_AFTER = 5
WAIT_S = 60.0
WINDOW = {"width": 1440, "height": 900}


def main() -> int:
    """Start again and again; return the exit code."""
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=200)
    parser.add_argument("--flown", type=float, default=2.0, help="seconds of each flight")
    parser.add_argument("--scenarios", default="lake,pool")
    parser.add_argument("--json", type=Path, help="also write what was lost, and when, to this file")
    options = parser.parse_args()
    logging.basicConfig(level=logging.WARNING)
    keep_threads_moving()
    lost: list[dict[str, Any]] = []
    station = Station(offered="lake")
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium-headless-shell", args=["--enable-unsafe-swiftshader"]
        )
        page = None
        for number, scenario in zip(range(options.starts), itertools.cycle(options.scenarios.split(",")), strict=False):
            if page is None or number % PAGES_AFTER == 0:
                if page is not None:
                    page.close()
                page = browser.new_page(viewport=WINDOW)
                page.goto(server.url.replace("ws", "http", 1))
            found = {"start": number, "scenario": scenario, **started(page, scenario, options.flown)}
            if found["lost"]:
                lost.append(found)
            if found["lost"] or number % 10 == 9:
                print(json.dumps(found), flush=True)
        browser.close()
    if options.json is not None:
        options.json.write_text(json.dumps(lost, indent=1) + "\n", encoding="utf-8")
    reasons = Counter(each["lost"] for each in lost)
    print(f"{options.starts} starts; lost: {dict(reasons) or 'none'}")
    return verdict(reasons)


def started(page: Any, scenario: str, flown_s: float) -> dict[str, Any]:
    """Start a scenario, fly, and quit; return what was lost, if anything, and how long the start took [s]."""
    wait(page, "Boolean(document.querySelector('#field-scenario')) && station.station.state.phase === 'idle'")
    page.select_option("#field-scenario", scenario)
    page.evaluate("""() => { globalThis.drops = [];
        for (const kind of ['close', 'trouble'])
          station.station.addEventListener(kind, (event) => drops.push(kind + ' ' + (event.detail ?? '')));
        station.station.bridge.addEventListener('status', (event) => drops.push(JSON.stringify(event.detail))); }""")
    before = page.evaluate("station.station.description?.session ?? station.station.state.session")
    began_s = time.monotonic()
    page.click("button[type=submit]")
    flies = "Boolean(station.station.isPilot && station.station.isRunning && station.telemetry.message)"
    lost = "" if wait(page, f"{flies} && station.station.description?.session > {before}") else "never had"
    took_s = time.monotonic() - began_s
    page.keyboard.press("w", delay=1e3 * flown_s)
    if not lost and not wait(page, "Boolean(station.station.isPilot)", 1.0):
        lost = "the controls"
    drops, state = page.evaluate("[drops, {lost_by: station.station.state.lost_by, silent: station.station.silence_s}]")
    if drops and not lost:
        lost = "the connection"
    if not page.evaluate("Boolean(station.station.isPilot)"):
        page.evaluate("station.station.takeControl()")
    page.evaluate("station.station.control('quit')")
    return {"lost": lost, "drops": drops, "took_s": round(took_s, 2), **state}


def wait(page: Any, condition: str, limit_s: float = WAIT_S) -> bool:
    """Wait until a condition is true on the page; return whether it became so."""
    end_s = time.monotonic() + limit_s
    while time.monotonic() < end_s:
        if page.evaluate(condition):
            return True
        time.sleep(0.05)
    return False


if __name__ == "__main__":
    sys.exit(main())
