"""The station's page shows an arm: a slider for each joint moves it, and it is drawn where its links are."""

from pathlib import Path

import pytest

from browser import judge, shows, until, when
from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.operator.station import Site, Station
from uwsim.simulator.simulator import Simulator

REACH = """
name: reach
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - {name: rov, model: bluerov2_heavy_alpha5, start: {position_m: [0, 0, -4]}}
"""


def test_sliders_move_joints_and_halt_stops_them(browser, tmp_path: Path) -> None:
    path = tmp_path / "reach.yaml"
    path.write_text(REACH)
    station = Station(is_fixed=True, folder=tmp_path)
    with RosbridgeServer(None, guests=[station], site=Site(station)) as server, station.serving(server.show):
        live = LiveSimulator(Simulator(path))
        station.run(lambda: live)
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{server.port}/")
        page.wait_for_selector("#arm:not([hidden])")
        when(page, "station.station.isPilot")
        arm = live.simulator.rov.arm
        assert arm is not None
        page.locator("#arm input").nth(1).fill("0.6")
        until(lambda: arm.read().positions[1] == pytest.approx(0.6, abs=0.05), "the upper arm's position")
        shows(page, "#arm", "34")  # 0.6 rad in degrees
        when(page, "station.objects.outlines().length === 6")  # its six links on the chart
        judge(page, "arm")
        page.locator("#arm input").nth(0).fill("2.0")
        until(lambda: arm.read().speeds[0] > 0.3, "the shoulder's turn")
        page.click("#halt-arm")
        until(lambda: abs(arm.read().speeds[0]) < 1e-3, "the halt")
        assert arm.read().positions[0] < 1.9
        page.close()
