"""Draw the screenshots of the operator's station: docs/connections/station-start.jpg and station.jpg.

They show a pilot's page in headless Chromium, next to a pipeline in the lake, after a lane over the bed has been
mapped. Needs the development installation (tools/setup --dev). `--extra FOLDER` also writes screens for visual
inspection: at dusk, with alarms, in the light theme and on a phone.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from playwright.sync_api import Browser, Page, sync_playwright

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


def open_page(browser: Browser, url: str, **options: object) -> Page:
    """Open a page of a running simulator."""
    page = browser.new_page(**{"viewport": SIZE, "color_scheme": "dark", **options})  # type: ignore[arg-type]
    page.goto(url)
    return page


def main(extra: Annotated[Path | None, typer.Option(help="Folder for further screens.")] = None) -> None:
    """Draw the two screenshots."""
    station = Station(offered="lake")
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        url = server.url.replace("ws", "http", 1)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--enable-unsafe-swiftshader"])
        page = open_page(browser, url)
        page.set_viewport_size(WHOLE_START)  # type: ignore[arg-type]
        until(page, "document.querySelector('.preview:not([hidden]) img')?.naturalWidth")
        shoot(page, DOCS / "connections" / "station-start.jpg")
        page.set_viewport_size(SIZE)  # type: ignore[arg-type]
        page.click("button[type=submit]")
        until(page, "globalThis.station.telemetry.message && station.station.isPilot")
        live = station.present().live
        survey_a_lane(live)
        shoot(page, DOCS / "connections" / "station.jpg")
        if extra is not None:
            extra.mkdir(parents=True, exist_ok=True)
            further(browser, page, url, live, extra)
        browser.close()


def further(browser: Browser, page: Page, url: str, live: LiveSimulator, folder: Path) -> None:
    """Take the additional screenshots that are inspected before a release."""
    for name in ("scene", "fan", "chase"):
        page.evaluate(f"station.views.enlarge('{name}')")
        shoot(page, folder / f"{name}.jpg")
    page.evaluate("station.views.enlarge('front')")
    live.command("set_optics", sun_elevation_deg=1.0).result()
    shoot(page, folder / "dusk.jpg")
    place(live, -72.0, -23.6, 0.2, 22.0)  # on the bed
    page.keyboard.down("Space")
    shoot(page, folder / "alarm.jpg")
    page.keyboard.up("Space")
    live.command("set_optics", sun_elevation_deg=60.0).result()
    place(live, *BESIDE_PIPE)
    for name, options in {
        "light": {"color_scheme": "light"},
        "phone": {"viewport": {"width": 400, "height": 860}, "has_touch": True, "is_mobile": True},
    }.items():
        other = open_page(browser, url, **options)
        until(other, "globalThis.station?.telemetry?.message")
        shoot(other, folder / f"{name}.jpg")
        other.close()


if __name__ == "__main__":
    typer.run(main)
