"""The operator's station in a browser: its start screen, and its main screen in flight (Figs. 4 and 5).

Playwright captures the screens in a Chromium on this machine. If either is missing, the stored pictures beside this
file are used, which were captured in the same way.
"""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from uwsim.base.atomic_file import write_atomically
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.scenes import Place, place
from uwsim.instruments.cameras.image_file import write_image
from uwsim.operator.station import Site, Station
from uwsim.simulator.simulator import Simulator

KEPT = Path(__file__).parent
NAMES = ("fig04.png", "fig05.png")
BROWSERS = ("chromium-headless-shell", "chromium", "google-chrome")
OVER_THE_PIPELINE = (36.0, -101.0, -35.0), -28.0
"""Less than 10 m above the bed, at which the proximity warning is lit."""
PATIENCE_S = 180.0  # on a busy machine; a quiet one takes 5 s
FLOWN_S = 3.0  # long enough for the views and the panel to be updated


class NoBrowserError(Exception):
    """Raised if Playwright or a Chromium is missing."""


def screens(
    sim: Simulator, out: Path, offered: str = "paper", where: Place = OVER_THE_PIPELINE
) -> tuple[Figure, Figure]:
    """Draw Figs. 4 and 5 into a folder, and return them. sim: a simulator of the scenario `offered`. Raises OSError.

    offered: a packaged name or a path. where: where Fig. 5 begins, a position [m] and a yaw [deg].
    """
    try:
        with ThreadPoolExecutor(1) as apart:  # Playwright refuses a thread with an event loop, as notebooks have
            apart.submit(take_screens, out, offered, where).result()
        source = "Taken now, in the browser of this machine"
    except NoBrowserError as error:
        for name in NAMES:
            kept = np.asarray(Image.open((KEPT / name).with_suffix(".jpg")))
            write_image(out / name, kept, optimize=True)
        source = f"A kept picture: {error}"
    place(sim, where)
    panel = sim.rov.telemetry()
    start = Figure(
        4, "The start screen",
        f"What an operator chooses before a mission, on the page of `uwsim station {Path(offered).name}`. {source}.",
        "Theirs asks for address, port, battery time and one of four sonars; ours also for scenario, vehicle, tilt, "
        "seed, speed and link.",
        {"mission_time_s": sim.scenario.mission_time_s},
    )  # fmt: skip
    main = Figure(
        5, "The main screen",
        "The vehicle in flight above the pipeline: camera feeds, the vehicle's parameters, and the altitude "
        f"marked as near the bed. {source}; the values are those of the place where the flight begins.",
        "Theirs is a window of Unity; ours is a page in a browser, which also has the sonar and the growing map.",
        columns=("panel", "value"), rows=[
            ("depth [m]", round(panel.depth_m, 2)), ("distance to seabed [m]", round(panel.distance_to_seabed_m, 2)),
            ("distance to station [m]", round(panel.distance_to_station_m, 1)),
            ("temperature [deg C]", round(panel.temperature_deg_c, 2)),
            ("pressure [kPa]", round(1e-3 * panel.pressure_pa, 2)), ("battery [%]", round(panel.battery_percent, 1)),
            ("range warning", panel.range_warning), ("proximity warning", panel.proximity_warning),
            ("collision warning", panel.collision_warning),
        ],
    )  # fmt: skip
    return start, main


def take_screens(out: Path, offered: str = "paper", where: Place = OVER_THE_PIPELINE) -> None:
    """Capture both screens of a separate station on a free local port. Raises NoBrowserError."""
    station = Station(offered=offered, folder=out)
    with (
        _browser() as browser,
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
    ):
        page = browser.new_page(viewport={"width": 1280, "height": 1470}, color_scheme="dark")
        page.goto(server.url.replace("ws", "http", 1))
        _until(page, "document.querySelector('.preview:not([hidden]) img')?.naturalWidth")
        page.fill("#field-rosbridge_host", "localhost")  # as in the paper
        page.fill("#field-rosbridge_port", str(ROSBRIDGE_PORT))
        _shoot(page, out / NAMES[0], 0.5)
        page.fill("#field-rosbridge_host", "")
        page.set_viewport_size({"width": 1440, "height": 900})
        page.click("button[type=submit]")
        _until(page, "globalThis.station.telemetry.message && station.station.isPilot")
        live = station.present().live
        (x, y, z), yaw_deg = where
        half = 0.5 * math.radians(yaw_deg)
        orientation = [0.0, 0.0, math.sin(half), math.cos(half)]
        live.command("place", vehicle="rov", position_world_m=[x, y, z], orientation_xyzw=orientation).result()
        live.command("set_lamp", vehicle="rov", lamp="front", on=True).result()
        live.pause()  # otherwise, on a busy machine, the large view's pictures leave no time for the others'
        _until(page, "station.views.names.every((name) => (station.views.picture(name)?.drawn ?? 1) > 0)")
        live.resume()
        page.keyboard.down("w")
        _shoot(page, out / NAMES[1], FLOWN_S)


@contextmanager
def _browser() -> Iterator[Any]:
    """Run a headless Chromium with software WebGL. Raises NoBrowserError."""
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        raise NoBrowserError("Playwright is not installed") from None
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=found, args=["--enable-unsafe-swiftshader"])
        except Error:
            raise NoBrowserError("no Chromium could be started") from None
        yield browser
        browser.close()


def _until(page: Any, expression: str) -> None:
    """Wait until a JavaScript expression is true in a page. Raises TimeoutError."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not page.evaluate(f"Boolean({expression})"):
        if time.monotonic() > deadline_s:
            raise TimeoutError(f"the station's page did not reach {expression}")
        time.sleep(0.05)


def _shoot(page: Any, path: Path, after_s: float) -> None:
    """Write a screenshot of a page after a delay."""
    time.sleep(after_s)
    write_atomically(path, page.screenshot())
