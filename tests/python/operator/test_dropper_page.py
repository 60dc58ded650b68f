"""Droppers on the station's page: a button for each, which lets go of its next body."""

from pathlib import Path

from browser import desk, until, when

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
