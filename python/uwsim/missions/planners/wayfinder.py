"""Wayfinder: flies a vehicle from point to point, looking ahead, going around shoals and stopping before obstacles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from uwsim.base.arguments import require_positive
from uwsim.base.arrays import Floats
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.lookout import Lookout
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps, until_at
from uwsim.navigation.control.protocols import PingLike

STOP_M, STOP_S = 2.5, 2.0  # the vehicle stops for obstacles at its height within STOP_M + STOP_S x speed of its origin
CLEARANCE_M = 1.5  # clearance below the vehicle when it flies highest
PASSABLE_Z_M = HIGHEST_Z_M - CLEARANCE_M
"""Anything higher is a shoal."""
GRACE_S = 60.0  # added to a path's time limit, which is otherwise five times its nominal duration
HALF_WIDTH_M = 1.5  # half the width of the corridor in which objects at the vehicle's height block its way
VIEW_S = 12.0  # look-ahead time at which the sonar's fan hits a flat bed
TURN_FIRST_RAD = math.radians(25.0)
ECHOES_OF_A_THING = 3  # fewer echoes at the vehicle's height may be false detections

OnPing = Callable[[PingLike, Floats], object]


class Wayfinder(Lookout):
    """A lookout that travels to waypoints and charts the shoals that it cannot pass over.

    Also uses a level range finder called 'proximity_fore' if the vehicle has one. view_m: distance ahead at which the
    tilted fan hits a flat bed. on_ping: called with each ping and its echoes (n, 3) in the world frame. Raises
    ValueError for invalid arguments.
    """

    speed_m_s: float
    view_m: float

    def __init__(
        self, vehicle: OwnVehicle, altitude_m: float, speed_m_s: float, *, on_ping: OnPing | None = None
    ) -> None:
        require_positive(altitude_m=altitude_m, speed_m_s=speed_m_s)
        self.speed_m_s = float(speed_m_s)
        self.view_m = max(2.0 * altitude_m, VIEW_S * speed_m_s)
        super().__init__(
            vehicle,
            altitude_m,
            half_width_m=HALF_WIDTH_M + 0.5,
            ahead_m=1.5 * self.view_m,
            passable_z_m=PASSABLE_Z_M,
            turn_first_rad=TURN_FIRST_RAD,
        )
        self._fore = vehicle.sensors.get("proximity_fore")
        self._on_ping = on_ping
        self._ahead_m = math.inf
        self._echoes = np.empty((0, 3))

    @property
    def swath_m(self) -> float:
        """Width of the fan where it hits a flat bed, from a new ping's beam angles; see `tilt`."""
        ping = self.vehicle.sonar.ping()
        angles = np.asarray(getattr(ping, "angles_rad", np.array([-0.5, 0.5])), np.float64)
        return 2.0 * math.hypot(self.view_m, self.altitude_m) * math.tan(0.5 * float(np.ptp(angles)))

    @property
    def echoes_world_m(self) -> Floats:
        """The echoes of the latest ping, (n, 3), in the world frame."""
        return self._echoes

    @property
    def ahead_m(self) -> float:
        """Distance to the nearest obstacle ahead at the vehicle's height, as last observed; inf if there is none."""
        return self._ahead_m

    @property
    def must_stop(self) -> bool:
        """Whether the vehicle must stop because an obstacle at its height is close ahead."""
        return self._ahead_m < STOP_M + STOP_S * self.speed_m_s

    def tilt(self) -> Steps[None]:
        """Tilt the sonar for the view distance, and wait on the spot until the head has reached that tilt."""
        tilt_rad = -math.atan2(self.altitude_m, self.view_m)
        sonar = self.vehicle.sonar
        sonar.aim(tilt_rad)
        yield from until_at(sonar, tilt_rad)

    def go_to(
        self,
        point_world_m: Sequence[float] | Floats,
        *,
        within_m: float = 1.0,
        enough: Callable[[], bool] = lambda: False,
    ) -> Steps[bool]:
        """Travel to a point (2,), around shoals seen on the way, until within within_m of it or `enough` returns true.

        Returns False if there is no path to it or it was not reached in time.
        """
        goal = float(point_world_m[0]), float(point_world_m[1])
        x, y, _ = self.vehicle.pose.position_world_m.tolist()
        end_s = self.vehicle.time_s + GRACE_S + 5.0 * math.dist((x, y), goal) / self.speed_m_s
        while math.dist((x, y), goal) > within_m:
            aim = self.shoals.next_point((x, y), goal)
            if enough():
                return True
            if aim is None or self.vehicle.time_s > end_s:
                return False
            yield from self.towards(aim)
            x, y, _ = self.vehicle.pose.position_world_m.tolist()
            if self.must_stop:
                yaw_rad = self.vehicle.pose.yaw_rad
                self.shoals.close((x + self.ahead_m * math.cos(yaw_rad), y + self.ahead_m * math.sin(yaw_rad)))
        return True

    def towards(self, point_world_m: Sequence[float] | Floats) -> Steps[None]:
        """Fly one control period towards a point (2,), slowing down near it."""
        x, y, _ = self.vehicle.pose.position_world_m.tolist()
        to = float(point_world_m[0]), float(point_world_m[1])
        yield from self.head_for(to, min(self.speed_m_s, 0.15 + 0.4 * math.dist(to, (x, y))))

    def look(self) -> PingLike:
        """Ping, and record shoals ahead and obstacles in the way; called by `steer`."""
        ping, pose = super().look(), self.vehicle.pose
        points = np.asarray(ping.points_sonar_m, np.float64)
        points = points[np.isfinite(points[:, 0])]
        self._echoes = points @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
        self._ahead_m = self._distance_ahead_m(np.asarray(pose.position_world_m, np.float64), pose.yaw_rad)
        if self._on_ping is not None:
            self._on_ping(ping, self._echoes)
        return ping

    def _distance_ahead_m(self, position: Floats, yaw_rad: float) -> float:
        """Return the distance to the nearest obstacle ahead that rises above half the altitude below the vehicle."""
        away = self._echoes - position
        ahead = away @ (math.cos(yaw_rad), math.sin(yaw_rad), 0.0)
        aside = away @ (-math.sin(yaw_rad), math.cos(yaw_rad), 0.0)
        in_the_way = (ahead > 0.0) & (np.abs(aside) < HALF_WIDTH_M) & (away[:, 2] > -0.5 * self.altitude_m)
        things = np.sort(ahead[in_the_way])
        seen_m = float(things[ECHOES_OF_A_THING - 1]) if len(things) >= ECHOES_OF_A_THING else math.inf
        if self._fore is None:
            return seen_m
        fore_m = float(self._fore.read())
        # a longer reading may be the bed or the sensor's maximum
        near = fore_m < STOP_M + STOP_S * self.speed_m_s
        return min(seen_m, fore_m) if near else seen_m
