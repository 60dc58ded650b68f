"""Lookout: decides how high and how fast to fly over obstacles seen by the sonar, and charts shoals in the way."""

from __future__ import annotations

import math

from uwsim.base.sealed import Sealed
from uwsim.missions.heights import HIGHEST_Z_M, HeightState, YoYo
from uwsim.missions.moves import CLIMB_M, steer
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.shoal_chart import ObstacleMemory, ShoalChart
from uwsim.missions.steps import Steps
from uwsim.navigation.control.autopilot import Autopilot, wrap_angle
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.protocols import PingLike
from uwsim.navigation.sensor_choice import altimeter

CLIMBS_WITHIN_M, CLIMB_BRAKE_M = 1.0, 4.0  # a larger remaining climb reduces the speed, to zero at the second value
SLOWEST = 0.1  # lowest fraction of the commanded speed


class Lookout(Sealed):
    """Steers a vehicle altitude_m above the bed and above obstacles that its sonar has seen ahead, and charts shoals.

    The vehicle needs a sonar and an altimeter. half_width_m, ahead_m: size of the corridor in which echoes are
    considered. passable_z_m: anything higher is a shoal. turn_first_rad: heading error above which the vehicle turns
    before moving. most_climb_m: limit on the height error used for steering. autopilot: defaults to the vehicle's own.
    A vehicle that nothing lifts climbs by its pitch, so it keeps its speed. yoyo: fly one instead of altitude_m above
    the bed; a vehicle that climbs by its pitch and keeps swinging about that height begins one by itself, above it.
    heights: the state of that. Raises ValueError without an altimeter.
    """

    vehicle: OwnVehicle
    altitude_m: float
    obstacles: ObstacleMemory
    shoals: ShoalChart
    heights: HeightState
    _fixed_when = "the lookout is made"

    def __init__(
        self,
        vehicle: OwnVehicle,
        altitude_m: float,
        *,
        half_width_m: float,
        ahead_m: float,
        passable_z_m: float,
        turn_first_rad: float,
        most_climb_m: float = CLIMB_M,
        autopilot: Autopilot | Controller | None = None,
        yoyo: YoYo | None = None,
    ) -> None:
        if (found := altimeter(vehicle.sensors)) is None:
            raise ValueError("the vehicle has no sensor of kind 'altitude': missions steer by it")
        self._altimeter = found
        self._lifts = "heave" in vehicle.controllable
        self.heights = HeightState(yoyo)
        self.vehicle, self.altitude_m = vehicle, float(altitude_m)
        self.obstacles = ObstacleMemory(half_width_m, ahead_m)
        self.shoals = ShoalChart(passable_z_m)
        self._turn_first_rad, self._most_climb_m, self._autopilot = turn_first_rad, most_climb_m, autopilot

    @property
    def period_s(self) -> float:
        """The control period."""
        return float((self.vehicle.autopilot if self._autopilot is None else self._autopilot).period_s)

    def head_for(
        self, point_world_m: tuple[float, float], speed_m_s: float, heading_rad: float | None = None
    ) -> Steps[None]:
        """Fly one control period towards a point, by default facing it; turn before moving."""
        pose = self.vehicle.pose
        x, y, _ = pose.position_world_m.tolist()
        to_x, to_y = point_world_m
        heading = math.atan2(to_y - y, to_x - x) if heading_rad is None else heading_rad
        if abs(wrap_angle(heading - pose.yaw_rad)) > self._turn_first_rad:
            speed_m_s = 0.0  # so that the sonar sees ahead before the vehicle moves
        away_m = max(math.dist((to_x, to_y), (x, y)), 1e-9)
        yield from self.steer(heading, (speed_m_s * (to_x - x) / away_m, speed_m_s * (to_y - y) / away_m))

    def steer(self, heading_rad: float, velocity_world_m_s: tuple[float, float]) -> Steps[None]:
        """Look ahead, then fly one control period at a heading and a velocity (2,), slowing down before a climb."""
        self.look()
        z_m = self._next_height_m()
        share = self.share_of_speed(z_m)
        east, north = velocity_world_m_s
        yield from self.steer_at(heading_rad, (share * east, share * north), z_m)

    def steer_at(self, heading_rad: float, velocity_world_m_s: tuple[float, float], z_world_m: float) -> Steps[None]:
        """Fly one control period at a heading, velocity (2,) and height z, without looking ahead."""
        return steer(
            self.vehicle, heading_rad, velocity_world_m_s, z_world_m, most_climb_m=self._most_climb_m,
            autopilot=self._autopilot,
        )  # fmt: skip

    def look(self) -> PingLike:
        """Ping, and record obstacles and shoals ahead; called by `steer`."""
        ping, pose = self.vehicle.sonar.ping(), self.vehicle.pose
        self.obstacles.add(ping, pose.position_world_m, pose.yaw_rad)
        self.shoals.add(ping)
        return ping

    def safe_height_m(self) -> float:
        """Return the height z that is altitude_m above both the bed below and any known obstacle ahead."""
        wanted_m = self._top_m() + self.altitude_m
        return min(wanted_m if math.isfinite(wanted_m) else float(self.vehicle.pose.position_world_m[2]), HIGHEST_Z_M)

    def bed_z_m(self) -> float:
        """Return the height z of the bed below the vehicle by its altimeter, -inf without an echo."""
        return float(self.vehicle.pose.position_world_m[2]) - float(self._altimeter.read())

    def _top_m(self) -> float:
        """Return the height z of the bed below or of a known obstacle ahead, whichever is higher; else -inf."""
        pose = self.vehicle.pose
        return max(self.bed_z_m(), self.obstacles.highest_m(pose.position_world_m, pose.yaw_rad))

    def _next_height_m(self) -> float:
        """Return the height z to steer for: a safe one, or that of the yo-yo."""
        vehicle, heights = self.vehicle, self.heights
        z_m = float(vehicle.pose.position_world_m[2])
        if heights.yoyo is None:
            wanted_m = self.safe_height_m()
            if self._lifts or not heights.swings_about(z_m, wanted_m, vehicle.time_s):
                return wanted_m
            begun = heights.begin_yoyo(self.altitude_m)
            vehicle.log("yoyo", upper_m=round(begun.upper_m, 1), lower_m=round(begun.lower_m, 1), above_bed=True)
        ahead, aside, _ = (vehicle.pose.world_from_body[:3, :3] @ vehicle.velocity.linear_body_m_s).tolist()
        return heights.next_z_m(z_m, self._top_m(), self.period_s * math.hypot(ahead, aside))

    def share_of_speed(self, z_world_m: float) -> float:
        """Return the fraction of full speed that lets the vehicle reach a height in time; below 1 during a climb."""
        climb_m = z_world_m - float(self.vehicle.pose.position_world_m[2])
        return min(max(1.0 - (climb_m - CLIMBS_WITHIN_M) / CLIMB_BRAKE_M, SLOWEST if self._lifts else 1.0), 1.0)
