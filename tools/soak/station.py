"""Soak test: the operator's station, flown in a browser for an hour, does not leak memory.

    .venv/bin/python tools/soak/station.py [--minutes 60] [--json FILE]

One page with pictures, sonar and the growing map drives the lake's vehicle, straight ahead and in turns. One line is
printed every minute, after a garbage collection. Map, track and log grow because the vehicle flies; caches fill in the
first minutes, which are ignored. The exit code is 1 if a straight line through the samples of the page's heap rises by
more than 20 MB per hour.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from steady import resident_mb, station_page, verdict

from uwsim.cli.run_live import keep_threads_moving

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
    with station_page("lake") as (station, page, _):
        samples = fly(page, station, options.minutes)
    if options.json is not None:
        options.json.write_text(json.dumps(samples, indent=1) + "\n", encoding="utf-8")
    kept = [each for each in samples if each["min"] > SETTLING_MIN]
    hours = [each["min"] / 60.0 for each in kept]
    rises = {
        name: float(np.polyfit(hours, [each[name] for each in kept], 1)[0])
        for name in ("heap_mb", "page_rss_mb", "server_rss_mb")
    }
    print(f"after the first {SETTLING_MIN:g} min, per hour: {rises}; heap at most {GROWTH_MB_PER_H:g}")
    return verdict(["heap"] if not rises["heap_mb"] <= GROWTH_MB_PER_H else [])


def fly(page: Any, station: Any, minutes: float) -> list[dict[str, float]]:
    """Drive astern, turn and go ahead in each minute; return one sample per minute."""
    session, processes = page.context.new_cdp_session(page), page.context.browser.new_browser_cdp_session()
    samples = []
    begun = time.monotonic()
    for minute in range(1, round(minutes) + 1):
        page.keyboard.press("s", delay=1e3 * ASTERN_S)  # held; away from any obstacle it has hit
        page.keyboard.press("q" if minute % 3 else "e", delay=1e3 * TURN_S)
        page.keyboard.press("w", delay=1e3 * max(begun + 60.0 * minute - time.monotonic(), 0.0))
        samples.append({"min": (time.monotonic() - begun) / 60.0, **sample(session, processes, page, station)})
        print("  ".join(f"{name} {value:.4g}" for name, value in samples[-1].items()), flush=True)
    return samples


def sample(session: Any, processes: Any, page: Any, station: Any) -> dict[str, float]:
    """Return the memory of the page's heap, the browser's processes that run pages and the server, and what grew."""
    session.send("HeapProfiler.collectGarbage")
    live = station.present().live
    found = page.evaluate("({voxels: station.scene.store.count, pictures: station.views.picture('front').drawn})")
    info = processes.send("SystemInfo.getProcessInfo")["processInfo"]
    return {
        "heap_mb": 1e-6 * session.send("Runtime.getHeapUsage")["usedSize"],
        "page_rss_mb": sum(resident_mb(each["id"]) for each in info if each["type"] == "renderer"),
        "server_rss_mb": resident_mb(),
        **found,
        "commands": len(list(live.log)),
        "pace": live.factor,
    }


if __name__ == "__main__":
    sys.exit(main())
