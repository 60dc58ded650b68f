"""Arm, droppers and tether on the station's page: sliders and driving keys, a button for each dropper, the winch."""

from pathlib import Path

import numpy as np
import pytest

from browser import desk, judge, shows, until, when

REACH = """
name: reach
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - {name: rov, model: bluerov2_heavy_alpha5, start: {position_m: [0, 0, -4]}}
"""
LOADED = """
name: loaded
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - name: rov
    model: bluerov2_heavy
    start: {position_m: [0, 0, -4]}
    droppers:
      left: {position_m: [0, 0.1, -0.3], yaw_pitch_roll_deg: [0, 90, 0], holds: [first]}
      right_tube: {position_m: [0.1, -0.4, -0.3], holds: [second, third], spacing_m: [0, 0, -0.1], spring_j: 1}
objects:
  - {shape: {kind: sphere, name: first, position_m: [0, 0, -1], radius_m: 0.03}, density_kg_m3: 2000}
  - {shape: {kind: sphere, name: second, position_m: [0, 0, -1], radius_m: 0.03}, density_kg_m3: 2000}
  - {shape: {kind: sphere, name: third, position_m: [0, 0, -1], radius_m: 0.03}, density_kg_m3: 2000}
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


def test_a_button_lets_go_of_the_next_body_of_its_dropper(browser, tmp_path: Path) -> None:
    (tmp_path / "loaded.yaml").write_text(LOADED)
    with desk(browser, tmp_path, str(tmp_path / "loaded.yaml")) as here:
        page = here.fly()
        when(page, "station.station.isPilot")
        page.click("#droppers button >> text=Right tube")
        until(lambda: here.rov.droppers["right_tube"].loaded == ("third",), "the launcher's first body")
        assert here.rov.droppers["left"].loaded == ("first",)
        page.click("#droppers button >> text=Left")
        until(lambda: here.rov.droppers["left"].loaded == (), "the dropper's body")
        assert not here.complaints


TETHERED = """
name: tethered
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
obstacles:
  - {kind: cylinder, name: pile, position_m: [2, 6, -4], radius_m: 0.3, length_m: 8}
vehicles:
  - name: rov
    model: bluerov2_heavy
    start: {position_m: [5, 0, -4]}
    tether: {anchor: [0, 0, -4], length_m: 6, elements: 12, winch: {longest_m: 12, fastest_m_s: 0.4}}
objects:
  - shape: {kind: sphere, name: buoy, position_m: [-3, 0, -4], radius_m: 0.2}
    density_kg_m3: 300
    tether: {anchor: [-3, 0, -6], length_m: 2, elements: 8}
"""


def test_the_page_draws_it_and_winds_its_winch(browser, tmp_path: Path) -> None:
    (tmp_path / "tethered.yaml").write_text(TETHERED)
    with desk(browser, tmp_path, str(tmp_path / "tethered.yaml")) as here:
        page = here.fly()
        when(page, "station.station.isPilot")
        when(page, "station.tethers.elementsOf('rov').length === 12")
        when(page, "station.tethers.elementsOf('buoy').length === 8")  # of a loose body

        def agrees() -> bool:
            drawn = page.evaluate("station.tethers.elementsOf('rov')")
            true = here.rov.tether.read().points_world_m
            return len(drawn) == len(true) - 1 and np.allclose([each[0] for each in drawn], true[:-1], atol=0.05)

        until(agrees, "its nodes")
        page.click("#winch-out")
        until(lambda: here.rov.tether.read().length_m > 6.5, "what the winch pays out")
        page.click("#winch-hold")
        until(lambda: here.rov.tether.read().rate_m_s == 0.0, "the winch's hold")
        page.fill("#tether input", "20")
        page.click("#winch-keep")
        until(lambda: here.rov.tether.read().anchor_tension_n > 15.0, "the tension that the winch keeps")
        here.rov.cut_tether(3.0)
        shows(page, "#tether h2 small", "broken")

        def has_pieces() -> bool:
            drawn, now = page.evaluate("station.tethers.elementsOf('rov')"), here.rov.tether.read()
            return len(now.tensions_n) - 1 <= len(drawn) <= len(now.tensions_n)

        until(has_pieces, "both pieces")
        assert not here.complaints
