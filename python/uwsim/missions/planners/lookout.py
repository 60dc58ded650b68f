"""Lookout: steers a vehicle over the bed and looks ahead in every control period, wherever it goes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.control.autopilot import wrap_angle
from uwsim.control.protocols import PingLike
from uwsim.missions.moves import steer
from uwsim.missions.obstacle_memory import ObstacleMemory
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.shoal_chart import ShoalChart
from uwsim.missions.steps import Steps, until
from uwsim.sealed import Sealed

HIGHEST_Z_M = -1.5
"""The vehicle never climbs above this height on its own."""
STOP_M, STOP_S = 2.5, 2.0  # what is at the vehicle's height stops it M + S x speed ahead of its middle
CLEARANCE_M = 1.5  # of the vehicle at its highest: what reaches higher is a shoal
GRACE_S = 60.0  # time for a way beside five times what its length needs
HALF_WIDTH_M = 1.5  # of the corridor in which that counts
VIEW_S = 12.0  # time ahead at which the sonar's fan meets a flat bed
TURN_FIRST_RAD = math.radians(25.0)
TILT_TOLERANCE_RAD, TILT_TIMEOUT_S = math.radians(0.5), 60.0
CLIMBS_WITHIN_M, CLIMB_BRAKE_M = 1.0, 4.0  # a climb still to be made slows down from the one on, over the other
ECHOES_OF_A_THING = 3  # fewer at the vehicle's height may be false detections

Hear = Callable[[PingLike, NDArray[np.float64]], object]


class Lookout(Sealed):
    """Keeps altitude_m above the bed and above what the sonar has seen ahead, and tells what cannot be passed over.

    The vehicle needs a sonar and a sensor 'altitude'; a level range finder 'proximity_fore' is used if there is one.
    view_m: distance ahead at which the tilted fan meets a flat bed. hear: called with each ping and its echoes (n, 3)
    in the world. Raises ValueError.
    """

    vehicle: OwnVehicle
    altitude_m: float
    speed_m_s: float
    view_m: float
    _fixed_when = "the lookout is made"

    def __init__(self, vehicle: OwnVehicle, altitude_m: float, speed_m_s: float, *, hear: Hear | None = None) -> None:
        for name, value, unit in (("altitude_m", altitude_m, "m"), ("speed_m_s", speed_m_s, "m/s")):
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} = {value} {unit}: must be positive")
        if "altitude" not in vehicle.sensors:
            raise ValueError("the vehicle has no sensor 'altitude': planners steer by it")
        self.vehicle, self.altitude_m, self.speed_m_s = vehicle, float(altitude_m), float(speed_m_s)
        self.view_m = max(2.0 * altitude_m, VIEW_S * speed_m_s)
        self._memory = ObstacleMemory(HALF_WIDTH_M + 0.5, ahead_m=1.5 * self.view_m)
        self._fore = vehicle.sensors.get("proximity_fore")
        self._shoals, self._hear = ShoalChart(HIGHEST_Z_M - CLEARANCE_M), hear
        self._ahead_m = math.inf
        self._echoes = np.empty((0, 3))

    @property
    def swath_m(self) -> float:
        """Width of the fan where it meets a flat bed, for the beams of the newest ping; see `tilt`."""
        ping = self.vehicle.sonar.ping()
        points = np.asarray(getattr(ping, "angles_rad", np.array([-0.5, 0.5])), np.float64)
        return 2.0 * math.hypot(self.view_m, self.altitude_m) * math.tan(0.5 * float(np.ptp(points)))

    @property
    def echoes_world_m(self) -> NDArray[np.float64]:
        """The echoes of the newest ping, (n, 3), world."""
        return self._echoes

    @property
    def ahead_m(self) -> float:
        """Distance ahead to what is at the vehicle's height, as last seen; inf if there is nothing."""
        return self._ahead_m

    @property
    def must_stop(self) -> bool:
        """Whether something at the vehicle's height is so near ahead that it must turn."""
        return self._ahead_m < STOP_M + STOP_S * self.speed_m_s

    def tilt(self) -> Steps[None]:
        """Tilt the sonar for the view, and wait on the spot until the head is there."""
        tilt_rad = -math.atan2(self.altitude_m, self.view_m)
        sonar = self.vehicle.sonar
        sonar.aim(tilt_rad)
        yield from until(
            lambda: abs(getattr(sonar, "elevation_rad", tilt_rad) - tilt_rad) < TILT_TOLERANCE_RAD,
            timeout_s=TILT_TIMEOUT_S,
        )

    def go_to(
        self,
        point_world_m: Sequence[float] | NDArray[np.float64],
        *,
        within_m: float = 1.0,
        enough: Callable[[], bool] = lambda: False,
    ) -> Steps[bool]:
        """Go to a point (2,), round the shoals that are seen on the way, until within_m of it or until it is enough.

        Return whether it got there; False if no way leads there, or none was found in time.
        """
        goal = float(point_world_m[0]), float(point_world_m[1])
        x, y, _ = self.vehicle.pose.position_world_m.tolist()
        end_s = self.vehicle.time_s + GRACE_S + 5.0 * math.dist((x, y), goal) / self.speed_m_s
        while math.dist((x, y), goal) > within_m:
            aim = self._shoals.next_point((x, y), goal)
            if enough():
                return True
            if aim is None or self.vehicle.time_s > end_s:
                return False
            yield from self.towards(aim)
            x, y, _ = self.vehicle.pose.position_world_m.tolist()
            if self.must_stop:
                yaw_rad = self.vehicle.pose.yaw_rad
                self._shoals.close((x + self.ahead_m * math.cos(yaw_rad), y + self.ahead_m * math.sin(yaw_rad)))
        return True

    def towards(self, point_world_m: Sequence[float] | NDArray[np.float64]) -> Steps[None]:
        """Fly one control period towards a point (2,), facing it: it turns before it goes."""
        x, y, _ = self.vehicle.pose.position_world_m.tolist()
        to_x, to_y = float(point_world_m[0]), float(point_world_m[1])
        away_m = max(math.hypot(to_x - x, to_y - y), 1e-9)
        heading = math.atan2(to_y - y, to_x - x)
        speed = min(self.speed_m_s, 0.15 + 0.4 * away_m)
        if abs(wrap_angle(heading - self.vehicle.pose.yaw_rad)) > TURN_FIRST_RAD:
            speed = 0.0
        yield from self.steer(heading, (speed * (to_x - x) / away_m, speed * (to_y - y) / away_m))

    def steer(self, heading_rad: float, velocity_world_m_s: tuple[float, float]) -> Steps[None]:
        """Fly one control period at a heading and a velocity (2,), slower while a climb is still to be made."""
        self.look()
        pose = self.vehicle.pose
        z_m = float(pose.position_world_m[2])
        bed_m = z_m - float(self.vehicle.sensors["altitude"].read())
        wanted_m = max(bed_m, self._memory.highest_m(pose.position_world_m, pose.yaw_rad)) + self.altitude_m
        target_m = min(wanted_m if math.isfinite(wanted_m) else z_m, HIGHEST_Z_M)
        share = min(max(1.0 - (target_m - z_m - CLIMBS_WITHIN_M) / CLIMB_BRAKE_M, 0.1), 1.0)
        east, north = velocity_world_m_s
        yield from steer(self.vehicle, heading_rad, (share * east, share * north), target_m)

    def look(self) -> None:
        """Ping, and note what is ahead. `steer` does so by itself."""
        ping, pose = self.vehicle.sonar.ping(), self.vehicle.pose
        position = np.asarray(pose.position_world_m, np.float64)
        self._memory.add(ping, position, pose.yaw_rad)
        self._shoals.add(ping)
        points = np.asarray(ping.points_sonar_m, np.float64)
        points = points[np.isfinite(points[:, 0])]
        self._echoes = points @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
        self._ahead_m = self._distance_ahead_m(position, pose.yaw_rad)
        if self._hear is not None:
            self._hear(ping, self._echoes)

    def _distance_ahead_m(self, position: NDArray[np.float64], yaw_rad: float) -> float:
        """Distance ahead of the nearest thing that is no lower than half the altitude below the vehicle."""
        away = self._echoes - position
        ahead = away @ (math.cos(yaw_rad), math.sin(yaw_rad), 0.0)
        aside = away @ (-math.sin(yaw_rad), math.cos(yaw_rad), 0.0)
        in_the_way = (ahead > 0.0) & (np.abs(aside) < HALF_WIDTH_M) & (away[:, 2] > -0.5 * self.altitude_m)
        things = np.sort(ahead[in_the_way])
        seen_m = float(things[ECHOES_OF_A_THING - 1]) if len(things) >= ECHOES_OF_A_THING else math.inf
        if self._fore is None:
            return seen_m
        fore_m = float(self._fore.read())
        near = fore_m < STOP_M + STOP_S * self.speed_m_s  # farther away it may be the bed, or its largest reading
        return min(seen_m, fore_m) if near else seen_m
