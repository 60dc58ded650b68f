"""Where the vehicle is, and how it flies to a point."""

import math

PERIOD_S = 0.1  # between two commands
NEAR_M, LEVEL_M, TURNED_RAD, STILL_RAD_S = 0.12, 0.15, 0.08, 0.05  # within which a point is reached
STEADY_RAD_S = 0.1  # a sonar that turns faster smears


def turn(angle_rad):
    """Return an angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi


class Steering:
    """Flies to points in turn, with at most a speed and a rate of turn.

    pose: x, y, z, yaw in the frame of odom. rows: the body's axes there. way: points to come: x, y, depth, heading
    and, if the vehicle is to stay there, the seconds; what follows is the pilot's own.
    """

    def __init__(self, speed_m_s=0.4, turn_rad_s=0.35):
        self.speed_m_s, self.turn_rad_s = speed_m_s, turn_rad_s
        self.pose = self.rows = None
        self.yaw_rate = 0.0
        self.way = []
        self.stayed_s = 0.0

    def see(self, odometry):
        """Take a message of odom."""
        place, q = odometry.pose.pose.position, odometry.pose.pose.orientation
        self.rows = (
            (1 - 2 * (q.y**2 + q.z**2), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w)),
            (2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x**2 + q.z**2), 2 * (q.y * q.z - q.x * q.w)),
            (2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x**2 + q.y**2)),
        )
        self.pose = (place.x, place.y, place.z, math.atan2(self.rows[1][0], self.rows[0][0]))
        self.yaw_rate = odometry.twist.twist.angular.z

    @property
    def is_steady(self):
        """True if a sonar does not smear."""
        return self.pose is not None and abs(self.yaw_rate) < STEADY_RAD_S

    def world(self, ahead, left, up):
        """Return the place (x, y, z) of a point of the body."""
        return tuple(self.pose[k] + r[0] * ahead + r[1] * left + r[2] * up for k, r in enumerate(self.rows))

    def command(self):
        """Return the velocity towards the next point, and drop the point once it is reached; without one, stop."""
        x, y, z, yaw = self.pose
        x_m, y_m, depth_m, heading_rad, *stay_s = self.way[0] if self.way else (x, y, -z, yaw)
        dx, dy, dz, turning = x_m - x, y_m - y, -depth_m - z, turn(heading_rad - yaw)
        far = math.hypot(dx, dy)
        is_there = far < NEAR_M and abs(dz) < LEVEL_M and abs(turning) < TURNED_RAD
        if self.way and is_there and abs(self.yaw_rate) < STILL_RAD_S:
            self.stayed_s += PERIOD_S
            if self.stayed_s > sum(stay_s[:1]):
                self.stayed_s = 0.0
                self.way.pop(0)
        speed = min(self.speed_m_s, 0.6 * far) / max(far, 1e-6)
        ahead, left = speed * dx, speed * dy
        forward, sideways = ahead * math.cos(yaw) + left * math.sin(yaw), left * math.cos(yaw) - ahead * math.sin(yaw)
        return {
            "linear": {"x": forward, "y": sideways, "z": max(min(0.8 * dz, 0.3), -0.3)},
            "angular": {"x": 0.0, "y": 0.0, "z": max(min(1.2 * turning, self.turn_rad_s), -self.turn_rad_s)},
        }
