"""Where the vehicle is, and how it flies to a point."""

import math

SPEED_M_S, TURN_RAD_S = 0.4, 0.35
STEADY_RAD_S = 0.15  # a sonar that turns faster smears


def turn(angle_rad):
    """Return an angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi


class Steering:
    """Flies to points in turn. pose: x, y, z, yaw in the frame of odom. way: points (x, y, depth, heading) to come."""

    def __init__(self):
        self.pose = None
        self.yaw_rate = 0.0
        self.way = []
        self.last = None  # the point that is held when there is no other

    def see(self, odometry):
        """Take a message of odom."""
        place, q = odometry.pose.pose.position, odometry.pose.pose.orientation
        yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        self.pose = (place.x, place.y, place.z, yaw)
        self.yaw_rate = odometry.twist.twist.angular.z
        if self.last is None:
            self.last = (place.x, place.y, -place.z, yaw)

    @property
    def is_steady(self):
        """Whether a sonar's picture does not smear."""
        return abs(self.yaw_rate) < STEADY_RAD_S

    def command(self):
        """Return the velocity towards the next point, and drop the point once it is reached; the last one is held."""
        if self.way:
            self.last = self.way[0]
        x_m, y_m, depth_m, heading_rad = self.last
        x, y, z, yaw = self.pose
        dx, dy, dz, turning = x_m - x, y_m - y, -depth_m - z, turn(heading_rad - yaw)
        far = math.hypot(dx, dy)
        if self.way and far < 0.12 and abs(dz) < 0.15 and abs(turning) < 0.08 and abs(self.yaw_rate) < 0.05:
            self.way.pop(0)
        speed = min(SPEED_M_S, 0.6 * far) / max(far, 1e-6)
        ahead, left = speed * dx, speed * dy
        forward, sideways = ahead * math.cos(yaw) + left * math.sin(yaw), left * math.cos(yaw) - ahead * math.sin(yaw)
        return {
            "linear": {"x": forward, "y": sideways, "z": max(min(0.8 * dz, 0.3), -0.3)},
            "angular": {"x": 0.0, "y": 0.0, "z": max(min(1.2 * turning, TURN_RAD_S), -TURN_RAD_S)},
        }
