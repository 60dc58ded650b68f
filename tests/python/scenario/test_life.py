"""Schools of fish: a function of seed and time that keeps clear of bed and surface, and that instruments meet."""

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.cover import LIFE

SCHOOL = {
    "kind": "school", "name": "herring", "count": 120, "size_m": [0.2, 0.3], "position_m": [0, 0, -5], "round_m": 4.0,
    "spread_m": [2.0, 1.0, 0.8],
}  # fmt: skip
SITE = {
    "name": "site",
    "terrain": {
        "source": "noise",
        "size_m": [60, 60],
        "spacing_m": 0.5,
        "bed_depth_m": 9,
        "hill_height_m": 4,
        "hill_wavelength_m": 12,
    },
    "optics": {"jerlov": "I"},
    "vehicles": [{"name": "rov", "model": "rov", "start": {"position_m": [-9, 0, -5]}}],
}


def site(**changes: object) -> Simulator:
    return Simulator(validated(Scenario, SITE | {"life": [SCHOOL | changes]}))


@pytest.mark.parametrize("place", [[0, 0, -5], [5, 3, -1.0], [-6, 4, -5.5]])
def test_fish_keep_clear_of_bed_and_surface_at_all_times(place: list[float]) -> None:
    sim = site(position_m=place, clear_m=0.5)
    for time_s in np.linspace(0, 200, 80):
        at, _ = sim.world.school_at(0, time_s)
        assert (at[:, 2] <= -0.5).all()
        assert (at[:, 2] >= sim.world.height_at(at[:, :2]) + 0.5).all()


def test_fish_swim_ahead_at_the_schools_speed_and_apart() -> None:
    sim, step_s = site(speed_m_s=0.6), 1e-3
    speeds = []
    for time_s in np.linspace(1, 90, 30):
        at, ahead = sim.world.school_at(0, time_s)
        moved = (sim.world.school_at(0, time_s + step_s)[0] - sim.world.school_at(0, time_s - step_s)[0]) / (2 * step_s)
        speed = np.linalg.norm(moved, axis=1)
        speeds.append(speed)
        assert np.median(np.sum(moved * ahead, axis=1) / speed) > 0.97
        apart = np.linalg.norm(at[:, None] - at[None], axis=2) + 10 * np.eye(len(at))
        assert np.median(apart.min(axis=1)) > 0.15
    assert np.mean(speeds) == pytest.approx(0.6, rel=0.15)
    assert np.linalg.norm(ahead, axis=1) == pytest.approx(1.0)


def test_places_depend_on_seed_and_time_alone() -> None:
    one, same, other = site(), site(), site(seed=7)
    then = one.world.school_at(0, 33.3)[0]
    one.advance(5.0)
    one.rov.sonar.ping()
    assert np.array_equal(one.world.school_at(0, 33.3)[0], then)
    assert np.array_equal(same.world.school_at(0, 33.3)[0], then)
    assert not np.array_equal(other.world.school_at(0, 33.3)[0], then)


def test_instruments_meet_fish_and_a_restored_run_meets_them_again() -> None:
    sim, again = site(), site()
    label = sim.label_names.index("herring")
    assert label == len(sim.label_names) - 1
    sim.advance(2.0)
    again.restore_state(sim.save_state())
    pings = [one.rov.sonar.ping() for one in (sim, again)]
    assert label in pings[0].labels[pings[0].valid]
    assert np.array_equal(pings[0].ranges_m, pings[1].ranges_m)
    frame = sim.rov.cameras["front"].capture()
    seen = frame.labels == label
    assert seen.sum() > 20 and (frame.pieces[seen] > 0).all() and not frame.pieces[~seen].any()
    assert frame.class_names[frame.classes[seen][0]] == "fish"
    assert np.array_equal(frame.rgb, again.rov.cameras["front"].capture().rgb)


def test_an_echo_is_at_the_range_of_the_nearest_fish_in_the_beam() -> None:
    sim = site()
    sim.advance(1.0)
    at, _ = sim.world.school_at(0, sim.time_s)
    eye = np.array([-9.0, 0.0, -5.0])
    scene = sim.around().scene
    for fish in at[::10]:
        ray = fish - eye
        distance = float(np.linalg.norm(ray))
        hit = scene.cast(eye[None], ray[None] / distance, 40.0)
        assert hit.ranges_m[0] <= distance + 0.05


def test_kinds_are_registered() -> None:
    assert list(LIFE.models(own=True)) == ["school"]


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"position_m": [0, 0, -20]}, "life 'herring' .*must be between the bed"),
        ({"position_m": [0, 0, 0]}, "must be between the bed"),
        ({"position_m": [90, 0, -5]}, "outside the terrain"),
        ({"size_m": [0.3, 0.2]}, "must not exceed its second"),
        ({"spread_m": [2, 3, 1]}, "at most half of round_m"),
        ({"name": "rov"}, "is already in use"),
        ({"kind": "whale"}, "school"),
    ],
)
def test_what_cannot_swim_is_refused(wrong: dict, rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        site(**wrong)
