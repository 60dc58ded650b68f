"""A yo-yo: its period and slope by closed form, its limits, bed and surface; a survey that begins one by itself."""

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml

import uwsim
from uwsim import Simulator
from uwsim.flight.flyable_lanes import survey_plan
from uwsim.missions import AdaptiveLawnMower, LawnMowerPlan, YoYo
from uwsim.missions.heights import HIGHEST_Z_M, HeightState
from uwsim.missions.planners.area_missions import yoyo
from uwsim.scenario.read.assets import find_yaml

SLOPE_DEG, SLOW_DEG_S = 12.0, 2.0


def slow(fins: dict) -> dict:
    return {name: fin | {"rate_max_deg_s": SLOW_DEG_S} for name, fin in fins.items()}


@pytest.fixture
def deep(tmp_path: Path):
    """Return a function that writes a flat basin, 30 m deep, with a REMUS 100, whose elevators may be slow."""

    def written(is_slow: bool = False) -> Path:
        remus = yaml.safe_load(find_yaml("remus100", "vehicles").read_text())
        elevators = {name: remus["fins"][name] for name in ("port", "starboard")}
        model = {"builds_on": "remus100"} | ({"fins": slow(elevators)} if is_slow else {})
        scenario = {
            "name": "deep",
            "terrain": {"source": "noise", "size_m": [400, 100], "bed_depth_m": 30, "spacing_m": 5},
            "vehicles": [{"name": "auv", "model": model, "start": {"position_m": [-150, -8, -10]}}],
            "survey": {
                "area_m": [[-100, -8], [100, -8], [100, 8], [-100, 8]], "altitude_m": 8, "line_spacing_m": 8,
                "speed_m_s": 1.5, "tilt_deg": 30,
            },
        }  # fmt: skip
        path = tmp_path / "deep.yaml"
        path.write_text(yaml.safe_dump(scenario))
        return path

    return written


def flown(path: Path, plan: LawnMowerPlan | None = None, lanes: int = 1) -> tuple[np.ndarray, AdaptiveLawnMower]:
    """Fly the first lanes; return time, x, y, z (n, 4) on lanes, and the mission."""
    rows = []
    with Simulator(path) as sim:
        mission = AdaptiveLawnMower(sim.rov, sim, plan or survey_plan(sim.scenario.survey))
        for wait in mission.steps():
            sim.wait(wait.duration_s)
            if mission.state.leg == "mow" and mission.state.lane < lanes:
                rows.append((sim.time_s, *sim.rov.pose.position_world_m))
            elif mission.state.lane >= lanes:
                break
    return np.array(rows), mission


def test_the_ramp_turns_after_the_height_over_the_tangent_of_the_slope() -> None:
    profile = YoYo(5.0, 15.0, slope_deg=SLOPE_DEG)
    state, z_m, turns, step_m = HeightState(profile), -5.0, [], 0.1
    for k in range(4000):
        descending = state.descending
        z_m = state.next_z_m(z_m, -30.0, step_m)  # a vehicle that follows at once
        if state.descending != descending:
            turns.append(k * step_m)
    assert np.diff(turns) == pytest.approx(10.0 / math.tan(math.radians(SLOPE_DEG)), abs=2 * step_m)


def test_a_remus_flies_the_period_and_the_slope_between_the_depths(deep) -> None:
    upper_m, lower_m = 8.0, 14.0
    plan = LawnMowerPlan([[-100, -4], [20, -4], [20, 4], [-100, 4]], 8.0, 8.0, 1.5,
                         yoyo=YoYo(upper_m, lower_m, slope_deg=SLOPE_DEG))  # fmt: skip
    track, mission = flown(deep(), plan)
    along_m, z_m = np.abs(track[:, 1] - track[0, 1]), track[:, 3]
    middle_z = -0.5 * (upper_m + lower_m)
    crossings = np.flatnonzero((z_m[:-1] > middle_z) & (z_m[1:] <= middle_z))  # on the way down
    period_m = 2.0 * (lower_m - upper_m - sum(mission.lookout.heights.early_m)) / math.tan(math.radians(SLOPE_DEG))
    assert len(crossings) >= 2
    assert np.diff(along_m[crossings]) == pytest.approx(period_m, rel=0.02)
    slopes_deg = [math.degrees(math.atan2(z_m[k] - z_m[k + 20], along_m[k + 20] - along_m[k])) for k in crossings]
    assert slopes_deg == pytest.approx([SLOPE_DEG] * len(slopes_deg), abs=0.5)
    assert -lower_m - 0.3 < z_m.min() < -lower_m + 0.5
    assert -upper_m - 0.5 < z_m[crossings[0] :].max() < -upper_m + 0.3


def test_a_survey_begins_a_yoyo_for_a_hull_that_cannot_stay_level(deep) -> None:
    track, mission = flown(deep(is_slow=True), lanes=2)
    profile = mission.lookout.heights.yoyo
    assert profile is not None and profile.above_bed and profile.lower_m == 8.0
    level = track[track[:, 1] < -60.0]
    assert level[:, 3].max() - level[:, 3].min() > 2.0, "it swings by metres"
    over_m = track[:, 3] + 30.0
    assert over_m.min() > 5.5 and over_m.max() > 12.0
    swift, mission = flown(deep())
    assert mission.lookout.heights.yoyo is None
    assert np.ptp(swift[200:, 3]) < 0.5


def test_it_stays_clear_of_the_bed_and_the_surface() -> None:
    flight = uwsim.fly(partial(yoyo, bound_m=14.0, speed_m_s=1.0), "lagoon", vehicle_model="remus100")
    samples = flight.samples["rov"]
    assert not flight.ended_early and flight.collisions == 0
    assert samples["altitude_m"].min() > 2.0
    assert samples["z_m"][samples["released"] > 0].max() < HIGHEST_Z_M + 0.5


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"upper_m": 9.0, "lower_m": 4.0}, "must be depths, upper_m above lower_m"),
        ({"upper_m": 4.0, "lower_m": 9.0, "above_bed": True}, "must be heights above the bed, lower_m below upper_m"),
        ({"upper_m": 4.0, "lower_m": 9.0, "slope_deg": 30.0}, r"slope_deg = 30 deg: must be in \(0, 18\] deg"),
        ({"upper_m": 4.0, "lower_m": 9.0, "clear_m": 0.0}, "clear_m = 0 m: must be positive"),
    ],
)
def test_bad_limits_are_refused(arguments: dict, rule: str) -> None:
    with pytest.raises(ValueError, match=rule):
        YoYo(**arguments)
