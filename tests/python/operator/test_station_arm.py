"""The station's page shows an arm where its links are; sliders, and the driving keys, move it."""

from pathlib import Path

import pytest

from browser import desk, judge, shows, until, when

REACH = """
name: reach
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - {name: rov, model: bluerov2_heavy_alpha5, start: {position_m: [0, 0, -4]}}
"""


def test_sliders_and_keys_move_joints_and_halt_stops_them(browser, tmp_path: Path) -> None:
    path = tmp_path / "reach.yaml"
    path.write_text(REACH)
    with desk(browser, tmp_path, str(path)) as here:
        page, arm = here.fly(), here.rov.arm
        page.wait_for_selector("#arm:not([hidden])")
        when(page, "station.station.isPilot")
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
        page.keyboard.press("Backslash")
        shows(page, "#arm-part option:checked", "hand")
        page.keyboard.down("w")
        until(lambda: abs(arm.read().speeds).max() > 0.02, "the hand, by the key that drives")
        assert not here.rov.effort.any()
        page.keyboard.up("w")
        until(lambda: abs(arm.read().speeds).max() < 1e-3, "its rest")
        page.select_option("#arm-part", "")
        page.keyboard.down("w")
        until(lambda: here.effort("surge") == 0.5, "the vehicle again")
        page.keyboard.up("w")
