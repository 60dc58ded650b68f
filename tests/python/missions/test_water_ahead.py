"""A lane goes on while there is water ahead, and a survey that was not flown is not complete."""

import itertools
import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import uwsim
from test_missions import ScriptedVehicle
from uwsim.evidence.scenario_check import check_file
from uwsim.flight.terminal import Silent
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan, StoppedError, mow
from uwsim.missions.water_ahead import is_water_ahead, recognised_ahead_m

FLAT = """
name: flat
mission_time_s: 3600
terrain: {{source: noise, size_m: [70, 40], spacing_m: 1, bed_depth_m: 12.1}}
obstacles: [{obstacles}]
vehicles: [{{name: rov, model: rov, start: {{position_m: [-14, -5, -9]}}, sonar: {{model: 2, tilt_deg: {tilt}}}}}]
survey: {{area_m: [[-10, -6], [10, -6], [10, 6], [-10, 6]], altitude_m: {altitude}, line_spacing_m: 4, speed_m_s: 0.6,
  tilt_deg: {tilt}, voxel_m: 0.5}}
"""


def ping(altitude_m: float, tilt_deg: float, fan_deg: float, wall_m: float = math.inf) -> SimpleNamespace:
    """Return a ping over a flat bed, with a wall across the lane: the beam at a reads h / (sin t cos a)."""
    angles, tilt = np.radians(np.linspace(-0.5 * fan_deg, 0.5 * fan_deg, 65)), math.radians(tilt_deg)
    directions = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    c, s = math.cos(tilt), math.sin(tilt)
    world_from_sonar = np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, altitude_m], [0, 0, 0, 1]])
    ranges = np.minimum(altitude_m / s, wall_m / c) / np.cos(angles)
    return SimpleNamespace(
        ranges_m=ranges,
        points_sonar_m=ranges[:, None] * directions,
        world_from_sonar=world_from_sonar,
        angles_rad=angles,
    )


def flat(folder: Path, altitude_m: float, tilt_deg: float = 30.0, obstacles: str = "") -> Path:
    path = folder / "flat.yaml"
    path.write_text(FLAT.format(altitude=altitude_m, tilt=tilt_deg, obstacles=obstacles))
    return path


@pytest.mark.parametrize("fan_deg", [29.0, 85.0, 170.0])
def test_a_flat_bed_is_water_ahead_at_any_height_and_a_wall_is_not(fan_deg: float) -> None:
    for altitude_m, tilt_deg in itertools.product((1.0, 2.0, 2.5, 3.0, 4.0, 8.0, 12.0), (15.0, 30.0, 60.0)):
        assert is_water_ahead(ping(altitude_m, tilt_deg, fan_deg), lambda: 0.0), (altitude_m, tilt_deg)
        half_fan_rad = math.radians(0.5 * fan_deg)
        wall_m = recognised_ahead_m(altitude_m, math.radians(tilt_deg), half_fan_rad)
        assert 0.0 < wall_m <= 0.5 * altitude_m / math.tan(math.radians(tilt_deg)) + 1e-9
        for away_m, expected in ((1.05 * wall_m, True), (0.95 * wall_m, False)):
            assert is_water_ahead(ping(altitude_m, tilt_deg, fan_deg, away_m), lambda: 0.0) is expected


def test_far_above_the_bed_the_published_seven_metres_decide() -> None:
    tilt_rad, half_fan_rad = math.radians(30.0), math.radians(42.5)
    published_m = 7.0 * math.cos(tilt_rad) * math.cos(half_fan_rad)
    assert recognised_ahead_m(8.0, tilt_rad, half_fan_rad) == pytest.approx(published_m)


def test_lanes_near_a_flat_bed_are_flown_to_their_ends(tmp_path: Path) -> None:
    altitude_m = 2.0
    flown = uwsim.run_survey(flat(tmp_path, altitude_m), tmp_path / "out", report="json", screen=Silent())
    assert (flown.result, flown.ended_early, flown.collisions) == (COVERED, False, 0)
    planned_m = 3 * (20.0 + 2.0 * altitude_m / math.tan(math.radians(30.0)))
    assert flown.lanes.planned_m == pytest.approx(planned_m, abs=0.1)
    assert flown.lanes.flown_m > 0.98 * planned_m and not flown.lanes.cut_short
    assert sum(lane["flown_m"] for lane in flown.lanes.each) == pytest.approx(flown.lanes.flown_m, abs=0.1)
    assert check_file(tmp_path / "flat.yaml").warnings == ()


@pytest.mark.usefixtures("blank_figures")
def test_lanes_that_a_wall_cuts_short_are_not_a_complete_survey(tmp_path: Path) -> None:
    wall = "{kind: box, name: wall, position_m: [2, 0, -8], size_m: [1, 30, 9]}"  # as high as 3.5 m below the surface
    plan = LawnMowerPlan([[-10, -6], [10, -6], [10, 6], [-10, 6]], 2.0, 4.0, 0.6)
    stopped = []

    def mission(vehicle):
        try:
            yield from mow(vehicle, plan)
        except StoppedError as stop:
            stopped.append(str(stop))
            raise

    flown = uwsim.fly(
        mission, flat(tmp_path, 2.0, obstacles=wall), tmp_path / "out", report="full", map=True, voxel_m=0.5
    )
    assert flown.collisions == 0
    lanes = flown.lanes
    assert 0.2 < lanes.flown_m / lanes.planned_m < 0.75 and len(lanes.cut_short) == lanes.lanes == 3
    (why,) = stopped
    assert flown.ended_early and flown.ended_because == why
    assert f"({lanes.flown_m:,.0f} of {lanes.planned_m:,.0f} m) was flown" in why
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["lanes"]["each"] == lanes.each
    assert "Lanes flown" in (tmp_path / "out" / "report.html").read_text()


def test_a_flight_that_its_battery_ends_counts_the_lane_begun() -> None:
    flown = uwsim.fly(None, "pool", mission_time_s=40.0)
    first = flown.lanes.each[-1]
    assert flown.ended_early and 0.0 < first["flown_m"] < first["planned_m"] and first["because"] == "the mission ended"
    assert flown.lanes.flown_m < 0.95 * flown.lanes.planned_m


@pytest.mark.parametrize(("spacing_m", "nearest_m"), [(2.0, 4.0), (6.0, 7.0)])
def test_only_what_is_in_the_way_to_port_ends_the_mission(spacing_m: float, nearest_m: float) -> None:
    """At 7 m, as published, where lanes are 5 m apart; and only where the next lane lies to port."""
    width_m = 4 * spacing_m
    area = [[-4.0, -4.0], [width_m + 4, -4.0], [width_m + 4, width_m - 4], [-4.0, width_m - 4]]
    plan = LawnMowerPlan(area_m=area, altitude_m=2.0, line_spacing_m=spacing_m, speed_m_s=0.5)
    for port_m, ends in ((nearest_m + 0.9, COVERED), (nearest_m - 0.9, "the proximity sensor reads")):
        vehicle = ScriptedVehicle(port_m=port_m)
        mission = AdaptiveLawnMower(vehicle, vehicle, plan)
        assert mission.run().startswith(ends)
    assert mission.state.lane == 2, "the first lane to port"


@pytest.mark.parametrize(
    ("altitude_m", "tilt_deg", "warning"),
    [(2.0, 70.0, "sees what is ahead 0.4 m before it"), (11.0, 30.0, "is at most 12.1 m deep")],
)
def test_a_geometry_that_cannot_work_is_warned_of(
    altitude_m: float, tilt_deg: float, warning: str, tmp_path: Path
) -> None:
    warnings = check_file(flat(tmp_path, altitude_m, tilt_deg)).warnings
    assert any("survey" in each and warning in each for each in warnings), warnings
