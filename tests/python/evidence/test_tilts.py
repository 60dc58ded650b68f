"""How far the packaged vehicles tilt under constant efforts, and under their own controllers."""

import numpy as np
import pytest

import docs_pages
from uwsim.base.axes import AXES
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.evidence.validate.tilts import largest_tilts_deg, tilt_table
from uwsim.navigation.control import Controller
from uwsim.scenario import load_vehicle
from uwsim.scenario.read.assets import packaged_names

BLUEROVS = ("bluerov2_heavy", "bluerov2_heavy_cfd", "bluerov2_tank", "bluerov2_wu")
UPRIGHT_DEG, OVER_DEG = 20.0, 90.0
LEVEL = [AXES.index(axis) for axis in ("surge", "sway", "heave")]


@pytest.mark.parametrize("name", BLUEROVS)
def test_a_bluerov2_stays_upright_up_to_full_effort(name: str) -> None:
    """In an ideal fluid, the Munk moment would turn each of them over ahead at full effort, or even at less."""
    model = load_vehicle(name)
    tilts_deg = largest_tilts_deg(model)
    assert tilts_deg[LEVEL].max() < UPRIGHT_DEG
    assert tilts_deg[AXES.index("yaw")].max() < 45.0, "spinning at some rad/s"
    ideal = largest_tilts_deg(model.model_copy(update={"munk_share": 1.0, "crossflow_length_m": 0.0}))
    assert ideal[AXES.index("surge"), -1] > OVER_DEG


@pytest.mark.parametrize("name", BLUEROVS)
@pytest.mark.parametrize("share", [0.5, 1.2])
def test_a_bluerov2s_controller_keeps_its_trim_beyond_the_demands_of_the_pages(name: str, share: float) -> None:
    """docs/guides/control.md claims this up to 1 m/s, which is speed_max_m_s. bluerov2_heavy reaches 0.84 m/s."""
    model = load_vehicle(name)
    demand_m_s = share * model.control.speed_max_m_s
    sim = deep_water(model, density_kg_m3=model.mass_kg / model.volume_m3)
    controller = Controller(sim.rov)
    for _ in range(round(30.0 / controller.period_s)):
        controller.velocity((demand_m_s, 0, 0, 0, 0, 0))
        sim.advance(controller.period_s)
        up = sim.rov.pose.world_from_body[2, 2]
        assert np.degrees(np.arccos(min(up, 1.0))) < UPRIGHT_DEG
    top_m_s = 0.84 if name == "bluerov2_heavy" else np.inf
    assert sim.rov.velocity.linear_body_m_s[0] == pytest.approx(min(demand_m_s, top_m_s), rel=0.05)
    assert abs(sim.rov.pose.position_world_m[2] - START_M[2]) < 1.0


def test_the_page_shows_the_largest_tilts() -> None:
    page = (docs_pages.ROOT / "docs" / "inside" / "stability.md").read_text().splitlines()
    printed = [line for line in page if line.startswith("| ")]
    got = tilt_table(packaged_names("vehicles"))
    assert [cells(row)[:2] for row in printed] == [cells(row)[:2] for row in got if "---" not in row], "\n".join(got)
    for shown, row in zip(printed[1:], [row for row in got if "---" not in row][1:], strict=True):
        difference = np.subtract([float(x) for x in cells(shown)[2:]], [float(x) for x in cells(row)[2:]])
        assert np.abs(difference).max() <= 2.0, f"{shown}\n{row}"


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip("|").split("|")]
