"""The tether on the station's page: drawn where it is by tension, and its winch."""

from pathlib import Path

import numpy as np

from browser import desk, shows, until, when

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
