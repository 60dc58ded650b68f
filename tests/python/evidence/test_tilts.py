"""How far packaged vehicles, also those with an arm, tilt under gravity, constant efforts and their controllers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import docs_pages
from uwsim.base.axes import AXES
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.evidence.validate.motion.tilts import largest_tilts_deg, tilt_table
from uwsim.evidence.validate.reality import arm_tilts
from uwsim.evidence.validate.reality.arm_tilts import (
    STATED_HULL_NM,
    Arm,
    arm_at,
    fitted_hull_nm,
    flown_deg,
    read_trials,
    rms_deg,
)
from uwsim.navigation.control import Controller
from uwsim.scenario import load_vehicle
from uwsim.scenario.read.assets import packaged_names

BLUEROVS = ("bluerov2_heavy", "bluerov2_heavy_cfd", "bluerov2_tank", "bluerov2_wu")
UPRIGHT_DEG, OVER_DEG = 20.0, 90.0
LEVEL = ("surge", "sway", "heave")


@pytest.mark.parametrize("name", ["bluerov2_heavy", "bluerov2_wu", "remus100"])
def test_the_page_shows_the_largest_tilts_and_a_bluerov2_stays_upright_up_to_full_effort(name: str) -> None:
    shown = [row for row in table_of_the_page()[1:] if row[0] == name]
    got = [cells(row) for row in tilt_table([name])[2:]]
    assert [row[:2] for row in shown] == [row[:2] for row in got], got
    degrees, degrees_shown = (np.array([row[2:] for row in rows], float) for rows in (got, shown))
    assert np.abs(degrees - degrees_shown).max(initial=0.0) <= 2.0, got
    if name in BLUEROVS:
        largest = {row[1]: each.max() for row, each in zip(got, degrees, strict=True)}
        assert max(largest[axis] for axis in LEVEL) < UPRIGHT_DEG
        assert largest["yaw"] < 45.0, "spinning at some rad/s"


def test_the_table_of_the_page_has_our_header_and_only_packaged_vehicles_in_their_order() -> None:
    header, *rows = table_of_the_page()
    assert header == cells(tilt_table([])[0])
    order = packaged_names("vehicles")
    places = [order.index(row[0]) for row in rows]
    assert places == sorted(places)


@pytest.mark.parametrize("name", BLUEROVS)
def test_in_an_ideal_fluid_a_bluerov2_would_turn_over(name: str) -> None:
    """The Munk moment would turn each of them over ahead at full effort, or even at less."""
    ideal = load_vehicle(name).model_copy(update={"munk_share": 1.0, "crossflow_length_m": 0.0})
    assert largest_tilts_deg(ideal, (1.0,))[AXES.index("surge"), 0] > OVER_DEG


@pytest.mark.parametrize("name", ["bluerov2_heavy", "bluerov2_wu"])  # with eight thrusters, and six
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


def table_of_the_page() -> list[list[str]]:
    page = (docs_pages.ROOT / "docs/reference/tilts.md").read_text().splitlines()
    return [cells(line) for line in page if line.startswith("| ")]


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip("|").split("|")]


DATA = Path(__file__).parents[4] / "shared/reality/hinsdale"
POSES = [{"b": 2.879, "c": 3.0, "d": 1.6, "e": 3.07}, {"b": 0.5, "c": 0.4, "d": 3.1, "e": 4.6}]


def held(angles_rad: dict[str, float]):
    """Return an arm that stays in a pose."""
    return lambda times_s: arm_at({column: np.full(len(times_s), angle) for column, angle in angles_rad.items()})


def at_rest_deg(moment_nm: np.ndarray) -> np.ndarray:
    x, y, z = moment_nm
    return np.degrees([np.arctan2(-x, np.hypot(y, z)), np.arctan2(y, z)])


@pytest.mark.parametrize("pose", POSES)
def test_the_simulated_vehicle_rests_where_its_moment_points_up(pose: dict[str, float]) -> None:
    moment_nm = np.array(STATED_HULL_NM) + held(pose)(np.zeros(1)).moment_nm[0]
    got = flown_deg(held(pose), np.array(STATED_HULL_NM), np.array([0.0, 1.0]))
    np.testing.assert_allclose(got[-1], at_rest_deg(moment_nm), atol=0.05)


def test_a_moved_arm_tilts_the_vehicle_within_some_seconds_and_not_at_once() -> None:
    before, after = POSES

    def moved(times_s: np.ndarray) -> Arm:
        return arm_at({c: np.where(times_s < 1.0, before[c], after[c]) for c in before})

    hull = np.array(STATED_HULL_NM)
    got = flown_deg(moved, hull, np.array([0.0, 1.0, 1.1, 60.0]))
    first, last = (at_rest_deg(hull + held(pose)(np.zeros(1)).moment_nm[0]) for pose in (before, after))
    assert np.abs(last - first).max() > 5.0
    np.testing.assert_allclose(got[:2], [first, first], atol=0.05)
    assert np.abs(got[2] - first).max() < 0.3 * np.abs(last - first).max(), "it has inertia"
    np.testing.assert_allclose(got[3], last, atol=0.1)


def three_trials() -> tuple[list, list]:
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}: docs/inside/reality.md lists the sources of the files")
    trials = read_trials(DATA)
    return [t for t in trials if t.name in ("traj014-2", "traj015-0", "traj026-2")], trials[::2]


def test_three_trials_are_met_by_the_hull_of_others_and_not_by_a_core_whose_statics_are_broken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judged, fitted = three_trials()
    hull = fitted_hull_nm([t for t in fitted if t not in judged])
    assert np.mean([rms_deg(flown_deg(t.arm, hull, t.times_s), t) for t in judged]) < 0.3

    def without_buoyancy_that_follows(model, **kwargs):
        sim = deep_water(model, **kwargs)
        update = sim.parameters.update

        def set_masses_only(changes):
            update({name: value for name, value in changes.items() if "buoyancy" not in name})

        monkeypatch.setattr(type(sim.parameters), "update", lambda self, changes: set_masses_only(changes))
        return sim

    deep_water = arm_tilts.deep_water
    monkeypatch.setattr(arm_tilts, "deep_water", without_buoyancy_that_follows)
    assert np.mean(rms_deg(flown_deg(judged[0].arm, hull, judged[0].times_s), judged[0])) > 2.0
