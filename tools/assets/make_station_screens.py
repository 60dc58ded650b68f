"""Draw the screenshots of the operator's station: docs/connections/station-start.jpg and station.jpg.

They show a pilot's page in headless Chromium, next to a pipeline in the lake, after a lane over the bed has been
mapped. Needs the development installation (tools/setup --dev).
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, sync_playwright

from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.operator.station import Site, Station

DOCS = Path(__file__).resolve().parents[2] / "docs"
CHROMIUM = "/usr/bin/chromium-headless-shell"
SIZE = {"width": 1440, "height": 900}
WHOLE_START = {"width": 1000, "height": 1400}
QUALITY = 86
LANE = ((-106.0, -76.0), (-80.0, -30.0))  # from near the dock to the pipeline
ABOVE_BED_M = 8.0
SHOWN = """[...document.querySelectorAll('.view:not([hidden])')].every(
    ({ dataset }) => (station.views.picture(dataset.view)?.drawn ?? 1) > 0)"""
BESIDE_PIPE = (-72.0, -23.6, 1.5, 22.0)  # x, y, height above the bed, yaw [deg]


def place(live: LiveSimulator, x: float, y: float, above_m: float, yaw_deg: float) -> None:
    """Place the ROV at a given height above the bed."""
    bed = float(live.simulator.world.height_at([[x, y]])[0])
    half = 0.5 * np.radians(yaw_deg)
    orientation = [0.0, 0.0, float(np.sin(half)), float(np.cos(half))]
    live.command("place", vehicle="rov", position_world_m=[x, y, bed + above_m], orientation_xyzw=orientation).result()


def survey_a_lane(live: LiveSimulator) -> None:
    """Map a lane of the bed, and stop next to the pipeline with the lamp on."""
    (x0, y0), (x1, y1) = LANE
    yaw_deg = float(np.degrees(np.arctan2(y1 - y0, x1 - x0)))
    for share in np.linspace(0.0, 1.0, 120):
        place(live, x0 + share * (x1 - x0), y0 + share * (y1 - y0), ABOVE_BED_M, yaw_deg)
        time.sleep(0.12)  # in real time: one or two pings
    place(live, *BESIDE_PIPE)
    live.command("set_lamp", vehicle="rov", lamp="front", on=True).result()


def until(page: Page, expression: str) -> None:
    """Wait until a JavaScript expression is true in the page."""
    deadline_s = time.monotonic() + 120.0
    while not page.evaluate(f"Boolean({expression})"):
        if time.monotonic() > deadline_s:
            raise TimeoutError(f"waited in vain for {expression}")
        time.sleep(0.05)


def shoot(page: Page, path: Path) -> None:
    """Take a screenshot of a page after its views have had time to update."""
    time.sleep(4.0)
    if page.is_visible("#station"):
        until(page, SHOWN)
        until(page, "!document.querySelector('.view.is-large.is-stale')")
    page.screenshot(path=path, type="jpeg", quality=QUALITY)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


def main() -> None:
    """Draw the two screenshots."""
    station = Station(offered="lake")
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--enable-unsafe-swiftshader"])
        page = browser.new_page(viewport=WHOLE_START, color_scheme="dark")  # type: ignore[arg-type]
        page.goto(server.url.replace("ws", "http", 1))
        until(page, "document.querySelector('.preview:not([hidden]) img')?.naturalWidth")
        shoot(page, DOCS / "connections" / "station-start.jpg")
        page.set_viewport_size(SIZE)  # type: ignore[arg-type]
        page.click("button[type=submit]")
        until(page, "globalThis.station.telemetry.message && station.station.isPilot")
        live = station.present().live
        survey_a_lane(live)
        shoot(page, DOCS / "connections" / "station.jpg")
        browser.close()


if __name__ == "__main__":
    main()
