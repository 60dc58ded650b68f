"""Draw docs/station.webp, the animation in the README: the operator's station while a map grows.

A mission connected over rosbridge flies the vehicle from the dock to a pipeline in the lake and then along it, while a
page in headless Chromium displays the flight. Needs the development installation (tools/setup --dev) and three minutes.
"""

from __future__ import annotations

import io
import threading
import time
from pathlib import Path

from make_station_screens import CHROMIUM, until
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from uwsim.bridges import RosbridgeServer
from uwsim.bridges.remote.flight import fly_remote
from uwsim.live import LiveSimulator
from uwsim.missions import OwnVehicle, Steps, goto, turn_to
from uwsim.operator.station import Site, Station

TARGET = Path(__file__).resolve().parents[2] / "docs" / "station.webp"
PAGE = {"width": 1280, "height": 800}
SIZE = (800, 500)
EVERY_S, SHOWN_MS, QUALITY = 2.0, 160, 42
LIMIT_BYTES = 2_000_000
EMPTY_FRAMES = 10  # until all views have pictures: the animation shows something from its first frame
LARGE = {0.0: "front", 14.0: "scene", 84.0: "front", 100.0: "scene"}  # the large view, by time since the start [s]
ALONG_M = ((-100.0, -30.0), (-65.0, -21.0), (-30.0, -12.0))  # the pipeline


def mission(vehicle: OwnVehicle) -> Steps[None]:
    """Fly from the dock to the pipeline, mapping the bed, and along it with the lamp on."""
    vehicle.lamps["front"].on = True
    vehicle.undock()
    yield from goto(vehicle, (-112.0, -62.0), altitude_m=9.0, speed_m_s=1.4)
    yield from goto(vehicle, ALONG_M[0], altitude_m=6.0, speed_m_s=1.4)
    yield from turn_to(vehicle, 0.25)
    for place in ALONG_M[1:]:
        yield from goto(vehicle, place, altitude_m=3.0, speed_m_s=1.2)


def frames(page: Page, live: LiveSimulator, flight: threading.Thread) -> list[Image.Image]:
    """Take screenshots of the page while the mission flies."""
    taken: list[Image.Image] = []
    flight.start()
    begun_s, shown = live.simulator.time_s, ""
    while flight.is_alive():
        now_s = live.simulator.time_s - begun_s
        if now_s < EVERY_S * len(taken):
            time.sleep(0.02)
            continue
        wanted = LARGE[max(start for start in LARGE if start <= now_s)]
        if wanted != shown:
            page.evaluate(f"station.views.enlarge('{wanted}')")
            shown = wanted
        picture = Image.open(io.BytesIO(page.screenshot()))
        taken.append(picture.convert("RGB").resize(SIZE, Image.Resampling.LANCZOS))
    return taken


def main() -> None:
    """Fly, take the screenshots and write the animation."""
    station = Station(offered="lake")
    with (
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--enable-unsafe-swiftshader"])
        page = browser.new_page(viewport=PAGE, color_scheme="dark")  # type: ignore[arg-type]
        page.goto(server.url.replace("ws", "http", 1))
        until(page, "document.querySelector('#hint-scenario')?.textContent")
        page.click("button[type=submit]")
        until(page, "globalThis.station.telemetry.message && station.station.isPilot")
        page.evaluate("() => void station.station.handOver('')")  # to the mission
        until(page, "!station.station.isPilot")
        live = station.present().live
        live.command("aim", vehicle="rov", elevation_rad=-0.5).result()
        time.sleep(6.0)  # time for the first pictures of all views
        taken = frames(page, live, threading.Thread(target=fly_remote, args=(mission, server.url)))
        browser.close()
    first, *others = taken[EMPTY_FRAMES:]
    first.save(TARGET, save_all=True, append_images=others, duration=SHOWN_MS, loop=0, quality=QUALITY)
    size = TARGET.stat().st_size
    print(f"{TARGET}: {len(others) + 1} frames, {size / 1000:.0f} kB")
    if size > LIMIT_BYTES:
        raise SystemExit(f"larger than {LIMIT_BYTES / 1e6:g} MB")


if __name__ == "__main__":
    main()
