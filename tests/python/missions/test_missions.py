"""Lanes, obstacle memory, autopilot, and the rules of the adaptive lawn-mower."""

import itertools
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.base.axes import AXES
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan
from uwsim.missions.lanes import lawn_mower_lanes
from uwsim.missions.shoal_chart import ObstacleMemory
from uwsim.navigation.control.autopilot import Autopilot, wrap_angle
from uwsim.scenario import load, load_vehicle

SQUARE = [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]]


def test_lanes_cover_the_polygon_and_each_starts_where_the_last_one_ended() -> None:
    area = np.array([[0, 0], [100, 20], [90, 80], [-10, 60]], float)
    lanes = lawn_mower_lanes(area, spacing_m=10.0, run_out_m=5.0, near_m=np.array([200.0, 100.0]))
    assert np.linalg.norm(lanes[0].start_m - [200, 100]) == min(
        np.linalg.norm(end - [200, 100]) for lane in (lanes[0], lanes[-1]) for end in (lane.start_m, lane.end_m)
    )
    for lane, following in itertools.pairwise(lanes):
        along, across = lane.locate(following.start_m)
        assert 0 < abs(across) <= 10.0 + 1e-9
        assert along > lane.length_m / 2, "the next lane starts at this one's end"
        assert lane.direction @ following.direction == pytest.approx(-1.0)
    # Every point of the polygon lies within half a spacing of some lane.
    points = np.random.default_rng(0).dirichlet(np.ones(4), 500) @ area
    for point in points:
        assert (
            min(abs(lane.locate(point)[1]) if 0 <= lane.locate(point)[0] <= lane.length_m else np.inf for lane in lanes)
            <= 5.0 + 1e-9
        )


def test_a_polygon_too_thin_for_a_lane_gets_one() -> None:
    lanes = lawn_mower_lanes([[0, 0], [50, 0], [50, 1], [0, 1]], 10.0, 0.0, np.zeros(2))
    assert len(lanes) == 1
    assert lanes[0].length_m == pytest.approx(50.0)


def _ping(points_world_m: list[list[float]]) -> SimpleNamespace:
    points = np.array(points_world_m, float)
    return SimpleNamespace(ranges_m=np.linalg.norm(points, axis=1), points_sonar_m=points, world_from_sonar=np.eye(4))


def test_obstacles_ahead_are_remembered_until_they_are_passed() -> None:
    memory = ObstacleMemory(half_width_m=3.0, ahead_m=20.0)
    memory.add(_ping([[10, 0, -5], [10, 1, -6], [10, 8, 3]]), np.zeros(3), 0.0)
    assert memory.highest_m(np.zeros(3), 0.0) == -5.0
    assert memory.highest_m(np.array([8.0, 0, 0]), 0.0) == -5.0
    assert memory.highest_m(np.array([14.0, 0, 0]), 0.0) == -np.inf, "passed"
    assert memory.highest_m(np.zeros(3), np.pi / 2) == -np.inf, "not along the heading"


@pytest.mark.parametrize("angle", [0.0, 3.0, -3.0, 7.0, 100.0])
def test_a_wrapped_angle_is_the_same_angle(angle: float) -> None:
    assert -np.pi <= wrap_angle(angle) < np.pi
    assert np.exp(1j * wrap_angle(angle)) == pytest.approx(np.exp(1j * angle))


def test_the_autopilot_holds_heading_height_and_velocity() -> None:
    sim = Simulator("pool")
    sim.rov.release()
    sim.rov.place([-7.0, -7.0, -2.0])
    autopilot = Autopilot(sim.rov)
    for _ in range(200):
        autopilot.steer(np.pi / 4, np.array([0.3, 0.3]), -3.0)
        sim.wait(0.1)
    pose, velocity = sim.rov.pose, sim.rov.velocity
    assert pose.yaw_rad == pytest.approx(np.pi / 4, abs=0.02)
    assert pose.position_world_m[2] == pytest.approx(-3.0, abs=0.05)
    assert velocity.linear_body_m_s[0] == pytest.approx(0.3 * np.sqrt(2), abs=0.03)
    assert velocity.linear_body_m_s[1] == pytest.approx(0.0, abs=0.03)


@pytest.mark.parametrize("model", ["rov", "bluerov2_heavy", "bluerov2_wu", "bluerov2_tank"])
@pytest.mark.filterwarnings("error::uwsim.simulator.helm.IdleAxisWarning")
def test_the_autopilot_holds_every_packaged_vehicle_still(model: str) -> None:
    sim = wide_pool(model)
    autopilot = Autopilot(sim.rov)
    rates = []
    for k in range(300):
        autopilot.steer(0.5, np.zeros(2), -2.5)
        sim.wait(0.1)
        if k >= 150:
            rates.append(np.abs(sim.rov.velocity.angular_body_rad_s).max())
    assert max(rates) < 0.05
    assert sim.rov.pose.yaw_rad == pytest.approx(0.5, abs=0.1)


def wide_pool(model: str, seconds: float = 60.0) -> Simulator:
    """Return a pool of 100 x 100 m with this vehicle, free in a corner of it."""
    pool, start = load("pool"), (-42.0, -12.0, -2.5)
    terrain = pool.terrain.model_copy(update={"size_m": (100.0, 100.0)})
    vehicle = pool.vehicles[0].model_copy(update={"model": load_vehicle(model)})
    sim = Simulator(pool.model_copy(update={"terrain": terrain, "vehicles": (vehicle,)}), mission_time_s=seconds)
    sim.rov.release()
    sim.rov.place(start)
    return sim


def test_the_autopilot_keeps_a_vehicle_level_that_would_nose_over_without_it() -> None:
    sim = wide_pool("bluerov2_heavy")
    autopilot = Autopilot(sim.rov, period_s=0.1)
    tilt_deg = []
    for _ in range(400):
        autopilot.steer(0.0, np.array([0.6, 0.0]), -2.5)
        sim.wait(0.1)
        tilt_deg.append(np.degrees(np.arccos(np.clip(sim.rov.pose.world_from_body[2, 2], -1.0, 1.0))))
    assert max(tilt_deg) < 20.0
    assert sim.rov.velocity.linear_body_m_s[0] == pytest.approx(0.6, abs=0.1)


@dataclass
class ScriptedVehicle:
    """Stand-in for a remote vehicle: it obeys instantly, and its beams and proximity sensor return preset values."""

    beams_m: float = 50.0
    port_m: float = 10.0
    battery_percent: float = 100.0
    position: np.ndarray = field(default_factory=lambda: np.array([-6.0, -6.0, -3.0]))
    yaw_rad: float = 0.0
    time_s: float = 0.0
    released: bool = True
    effort: dict[str, float] = field(default_factory=dict)

    @property
    def pose(self) -> SimpleNamespace:
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        matrix = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        return SimpleNamespace(position_world_m=self.position.copy(), world_from_body=matrix, yaw_rad=self.yaw_rad)

    @property
    def velocity(self) -> SimpleNamespace:
        return SimpleNamespace(linear_body_m_s=np.zeros(3), angular_body_rad_s=np.zeros(3))

    @property
    def sonar(self) -> SimpleNamespace:
        ping = SimpleNamespace(
            ranges_m=np.full(513, self.beams_m), points_sonar_m=np.full((513, 3), np.nan), world_from_sonar=np.eye(4)
        )
        ping.ranges_m[1:-1:2] = np.inf
        return SimpleNamespace(aim=lambda elevation_rad: None, ping=lambda: ping)

    @property
    def sensors(self) -> dict[str, SimpleNamespace]:
        return {
            "proximity_port": SimpleNamespace(read=lambda: self.port_m),
            "altitude": SimpleNamespace(read=lambda: 2.0),
        }

    def telemetry(self) -> SimpleNamespace:
        return SimpleNamespace(battery_percent=self.battery_percent)

    def release(self) -> None:
        self.released = True

    def set_effort(self, *values: float, **efforts: float) -> None:
        self.effort = dict(zip(AXES, values, strict=False)) | efforts

    def wait(self, duration_s: float) -> None:
        ahead = np.array([np.cos(self.yaw_rad), np.sin(self.yaw_rad)])
        left = np.array([-ahead[1], ahead[0]])
        step = self.effort.get("surge", 0.0) * ahead + self.effort.get("sway", 0.0) * left
        self.position[:2] += 0.5 * duration_s * step
        self.yaw_rad = wrap_angle(self.yaw_rad + duration_s * self.effort.get("yaw", 0.0))
        self.time_s += duration_s


PLAN = LawnMowerPlan(area_m=SQUARE, altitude_m=2.0, line_spacing_m=2.0, speed_m_s=0.5)


def test_a_mission_needs_only_the_public_names_of_a_vehicle_and_ends_by_itself() -> None:
    vehicle = ScriptedVehicle()
    mission = AdaptiveLawnMower(vehicle, vehicle, PLAN)
    assert mission.run() == COVERED
    assert mission.progress == pytest.approx(1.0)
    assert vehicle.effort == {}, "efforts are zero at the end"


def test_a_lane_ends_where_all_three_beams_read_seven_metres_or_less() -> None:
    free, walled = ScriptedVehicle(), ScriptedVehicle(beams_m=6.9)
    free_ended, walled_ended = (AdaptiveLawnMower(vehicle, vehicle, PLAN).run() for vehicle in (free, walled))
    assert walled.time_s < 0.7 * free.time_s
    assert free_ended == COVERED and "no water ahead on 3 of the lanes" in walled_ended


class Unturning(ScriptedVehicle):
    def wait(self, duration_s: float) -> None:
        yaw_rad = self.yaw_rad
        super().wait(duration_s)
        if self.time_s > 20.0:
            self.yaw_rad = yaw_rad


class Unmoving(ScriptedVehicle):
    def set_effort(self, *values: float, **efforts: float) -> None: ...


@pytest.mark.parametrize(
    ("vehicle", "ends"),
    [(ScriptedVehicle(battery_percent=0.0), "the battery is used up"), (Unturning(), "stuck"), (Unmoving(), "stuck")],
)
def test_a_vehicle_without_power_or_motion_ends_the_mission(vehicle: ScriptedVehicle, ends: str) -> None:
    assert ends in AdaptiveLawnMower(vehicle, vehicle, PLAN).run()


def test_a_vehicle_without_the_sensors_that_the_mission_needs_is_refused() -> None:
    class Blind(ScriptedVehicle):
        sensors = {}  # noqa: RUF012

    vehicle = Blind()
    with pytest.raises(ValueError, match="no sensor of kind 'altitude'"):
        AdaptiveLawnMower(vehicle, vehicle, PLAN)


def test_the_first_lane_begins_after_the_head_has_turned() -> None:
    class SlowHead(ScriptedVehicle):
        @property
        def sonar(self) -> SimpleNamespace:
            elevation_rad = -min(np.radians(30.0), 0.02 * self.time_s)  # reaches 30 degrees after 26 s
            return SimpleNamespace(**vars(super().sonar), elevation_rad=elevation_rad)

    vehicle = SlowHead()
    mission = AdaptiveLawnMower(vehicle, vehicle, PLAN)
    mown_s: list[float] = []
    mow = mission._mow
    mission._mow = lambda start: (mown_s.append(start.time_s), mow(start))[1]
    assert mission.run() == COVERED
    assert mown_s[0] >= 26.0
