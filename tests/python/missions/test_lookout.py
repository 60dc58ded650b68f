"""The lookout climbs in time over the bed and all obstacles that the sonar sees, by one rule for lanes and planners."""

import math
from dataclasses import dataclass, field
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from test_missions import PLAN, ScriptedVehicle
from uwsim.missions import AdaptiveLawnMower, OwnVehicle, drive
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.lookout import SLOWEST, Lookout
from uwsim.missions.planners.wayfinder import PASSABLE_Z_M, Wayfinder

ALTITUDE_M = 3.0


@dataclass
class Seeing(ScriptedVehicle):
    """A vehicle that holds still at 20 m depth, 5 m above the bed, and sees the given world points."""

    position: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, -20.0]))
    points_m: list[tuple[float, float, float]] = field(default_factory=list)

    @property
    def sonar(self) -> SimpleNamespace:
        points = np.array(self.points_m or [(math.nan,) * 3], float)
        ping = SimpleNamespace(ranges_m=np.full(len(points), 50.0), points_sonar_m=points, world_from_sonar=np.eye(4))
        return SimpleNamespace(aim=lambda elevation_rad: None, ping=lambda: ping)

    @property
    def sensors(self) -> dict[str, SimpleNamespace]:
        return super().sensors | {"altitude": SimpleNamespace(read=lambda: 5.0)}


def lookouts(vehicle: Seeing) -> list[Lookout]:
    own = OwnVehicle(vehicle, vehicle)
    plain = Lookout(own, ALTITUDE_M, half_width_m=2.0, ahead_m=20.0, passable_z_m=-3.5, turn_first_rad=0.5)
    return [plain, Wayfinder(own, ALTITUDE_M, speed_m_s=0.5)]


@pytest.mark.parametrize(
    ("points_m", "z_m"),
    [
        ([], -22.0),
        ([(8.0, 0.0, -19.0)], -16.0),
        ([(8.0, 0.0, -24.0)], -21.0),
        ([(8.0, 0.0, -30.0)], -22.0),
        ([(8.0, 8.0, -19.0)], -22.0),
        ([(-8.0, 0.0, -19.0)], -22.0),
        ([(8.0, 0.0, -2.0)], HIGHEST_Z_M),
    ],
    ids=["bed", "higher", "rising", "deeper", "aside", "behind", "to the surface"],
)
def test_the_height_is_above_the_bed_and_above_what_is_ahead(points_m, z_m: float) -> None:
    for lookout in lookouts(vehicle := Seeing(points_m=points_m)):
        lookout.look()
        assert lookout.safe_height_m() == pytest.approx(z_m)
        vehicle.points_m = []
        lookout.look()
        assert lookout.safe_height_m() == pytest.approx(z_m), "it remembers"
        vehicle.points_m = points_m


def test_a_climb_that_is_still_to_be_made_slows_the_vehicle_down() -> None:
    (lookout, _) = lookouts(vehicle := Seeing())
    assert type(AdaptiveLawnMower(vehicle, vehicle, PLAN).lookout) is type(lookout), "the lawn-mower's too"
    shares = [lookout.share_of_speed(z_m) for z_m in (-30.0, -20.0, -19.0, -17.0, -15.0, -5.0)]
    assert shares == pytest.approx([1.0, 1.0, 1.0, 0.5, SLOWEST, SLOWEST])


def test_a_vehicle_that_sees_a_wall_ahead_slows_down_and_rises(monkeypatch) -> None:
    vehicle = Seeing(points_m=[(8.0, 0.0, -16.0)])
    for lookout in lookouts(vehicle):
        core = Mock(steer=Mock(return_value=(0.0,) * 6))
        monkeypatch.setattr(lookout.vehicle.autopilot, "_core", core)
        drive(lookout.steer(0.0, (1.0, 0.0)), vehicle)
        ((_, _, heading_rad, (east_m_s, north_m_s), z_m),) = [call.args for call in core.steer.call_args_list]
        assert (heading_rad, north_m_s) == (0.0, 0.0)
        assert east_m_s == pytest.approx(SLOWEST) and z_m == pytest.approx(-19.0), "a metre of the climb at once"


def test_what_reaches_too_high_is_a_shoal_and_what_is_at_the_vehicles_height_stops_it() -> None:
    shoal = [(9.0 + 0.1 * k, 0.0, PASSABLE_Z_M + 0.2) for k in range(5)]
    near = [(3.0, 0.1 * k, -20.0) for k in range(3)]
    for lookout in lookouts(Seeing(points_m=shoal + near)):
        lookout.look()
        assert lookout.shoals.cells == [(2, 0)]
    assert lookout.ahead_m == pytest.approx(3.0) and lookout.must_stop
