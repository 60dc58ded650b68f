#!/usr/bin/env python3
"""Draw docs/guides/teleop.png: the pilot's terminal over the lake, rendered by textual and headless Chromium."""

import asyncio
from pathlib import Path

from playwright.async_api import async_playwright

from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.operator.teleop.app import TeleopApp
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.gamepad import Gamepads
from uwsim.operator.teleop.hands import Hands

TARGET = Path(__file__).parents[2] / "docs" / "guides" / "teleop.png"
PLACE_M, ALONG_XYZW = (-72.0, -50.0, -24.0), (0.0, 0.0, 0.3, 0.954)  # near a gate
SCREEN, PIXELS = (132, 40), {"width": 1340, "height": 860}


async def main() -> None:
    """Fly for some seconds, then take the screenshot."""
    with LiveSimulator("lake") as live, RosbridgeServer(live, port=0) as server:
        live.command("aim", vehicle="rov", elevation_rad=-0.1).result()
        live.command("place", vehicle="rov", position_world_m=PLACE_M, orientation_xyzw=ALONG_XYZW).result()
        app = TeleopApp(Connection(server.url, Hands()), "lake", Gamepads())
        async with app.run_test(size=SCREEN) as pilot:
            app.hands.reports_releases = True
            app.press("w")
            app.press("q")
            app.press("]")
            await pilot.pause(3.0)
            app.press("m")
            await pilot.pause(0.5)
            picture = app.export_screenshot(title="uwsim teleop")
        app.connection.stop()
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path="/usr/bin/chromium-headless-shell")
        page = await browser.new_page(viewport=PIXELS)
        await page.set_content(f"<body style='margin:0'>{picture}</body>")
        await page.locator("svg").screenshot(path=TARGET)
        await browser.close()


if __name__ == "__main__":
    asyncio.run(main())
