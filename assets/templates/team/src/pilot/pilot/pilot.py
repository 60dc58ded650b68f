"""The team's pilot: a plain class, which a ROS 2 node (node.py) and the simulator without ROS (simulated.py) drive.

It finds thin posts in the sonar's scan, and passes between them: the gate, then three rows of poles. Then it tilts the
sonar down, finds the rim of the bin, and drops a marker into it; tilts the sonar up, finds the octagon's pipes at the
surface, and comes up in their middle. The board with openings is left to you. Change it as you like; what the drivers
use is READS, WRITES, `receive` and `commands`.
"""

import math

from pilot.steering import Steering

READS = {"odom": "nav_msgs/msg/Odometry", "scan": "sensor_msgs/msg/LaserScan"}
DROP = "marker_dropper/drop"
WRITES = {"cmd_vel": "geometry_msgs/msg/Twist", "cmd_tilt": "std_msgs/msg/Float64", DROP: "std_msgs/msg/Empty"}

DEPTH_M = 1.1  # at which the scan meets the gate's legs and the poles, and passes below the signs
SONAR_M = (0.24, -0.06)  # the sonar's place ahead of and above the vehicle's origin
POST_M, RANGE_M, SAME_M = 0.3, 9.0, 0.35  # widest post, farthest one that is used, distance that makes two of them one
GATE_M, ROW_M = 3.05, 1.5  # distance between the gate's legs, and between the poles of a row
GATE_X_M = -4.0  # it stands west of this, as the rules state
OCTAGON_X_M, PIPES_M = 9.5, (1.25, 1.55)  # where it is, as the rules state, and how far its pipes are from its middle
SHALLOW_M, UP_RAD = 0.8, 0.3  # depth and tilt with which the sonar meets the surface 2.8 m ahead
BIN_M, RIM_Z_M = (4.7, 4.0), (-2.3, -2.1)  # where the bin is, as the rules state, and the height of its rim
OVER_M, DROP_M, DROPPER_M = 1.1, 1.5, -0.1  # depths over the bin, and how far ahead of the origin they leave it
TILT_S = 18.0  # in which the head tilts by a right angle


class Posts:
    """The posts seen so far: [x, y, number of sightings], in the frame of odom."""

    def __init__(self):
        self.found = []

    def add(self, x_m, y_m):
        """Add a sighting to the nearest post, or a new one."""
        near = [post for post in self.found if math.dist(post[:2], (x_m, y_m)) < SAME_M]
        if not near:
            self.found.append([x_m, y_m, 1])
            return
        post = min(near, key=lambda each: math.dist(each[:2], (x_m, y_m)))
        weight = 1.0 / min(post[2] + 1, 20)
        post[0] += weight * (x_m - post[0])
        post[1] += weight * (y_m - post[1])
        post[2] += 1

    def sure(self, beyond_x_m):
        """Return the posts that were seen often enough, from starboard to port."""
        return sorted(((x, y) for x, y, n in self.found if n >= 4 and x > beyond_x_m), key=lambda post: post[1])


class Pilot:
    """Steers from an opening to the next. log: called with what it decides."""

    def __init__(self, log=print):
        self.log = log
        self.posts = Posts()
        self.steering = Steering()
        self.passed = self.looked = 0  # openings: the gate, then the rows; and looks for the next one
        self.looking = [0.0, 0.6, -0.6, 0.0]  # headings still to be looked at
        self.up_rad = 0.0  # the sonar's tilt
        self.echoes = []  # with the head tilted, from the surface or the bin's rim: (x, y)
        self.drops = 0  # markers to drop now
        self.later = [self.to_bin, self.over_bin, self.above_bin, self.to_octagon, self.in_octagon]

    def receive(self, topic, message):
        """Take a message of one of READS."""
        if topic == "odom":
            self.steering.see(message)
        elif self.steering.is_steady:
            self.see(message)

    def see(self, scan):
        """Add the scan's posts: a few beams that are nearer than those on both sides."""
        x, y, z, yaw = self.steering.pose
        x, y = x + SONAR_M[0] * math.cos(yaw), y + SONAR_M[0] * math.sin(yaw)
        ranges = [r if r and scan.range_min < r < scan.range_max else 99.0 for r in scan.ranges]
        if self.up_rad:
            self.see_tilted(ranges, scan, x, y, z + SONAR_M[1], yaw)
            return
        first = 0
        for k in range(1, len(ranges) + 1):
            if k < len(ranges) and abs(ranges[k] - ranges[k - 1]) < 0.2:
                continue
            middle = ranges[(first + k - 1) // 2]
            is_thin = (k - first) * scan.angle_increment * middle < POST_M
            is_alone = first > 0 and k < len(ranges) and min(ranges[first - 1], ranges[k]) > middle + 0.5
            if middle < RANGE_M and is_thin and is_alone:
                bearing = yaw + scan.angle_min + 0.5 * (first + k - 1) * scan.angle_increment
                self.posts.add(x + middle * math.cos(bearing), y + middle * math.sin(bearing))
            first = k

    def see_tilted(self, ranges, scan, x, y, z, yaw):
        """Add echoes from the surface, or from as high as the rim of the bin."""
        low, high = RIM_Z_M if self.up_rad < 0.0 else (-0.15, 0.15)
        for k, r in enumerate(ranges):
            beam = scan.angle_min + k * scan.angle_increment
            ahead, left = r * math.cos(beam) * math.cos(self.up_rad), r * math.sin(beam)
            if low < z + r * math.cos(beam) * math.sin(self.up_rad) < high:
                east = x + ahead * math.cos(yaw) - left * math.sin(yaw)
                self.echoes.append((east, y + ahead * math.sin(yaw) + left * math.cos(yaw)))

    def commands(self):
        """Return the messages to publish now, a list of pairs of a topic and plain values."""
        if self.steering.pose is None:
            return []
        if not self.steering.way:
            self.steering.way = self.choose()
        drop, self.drops = [(DROP, {})] * self.drops, 0
        tilt = {"data": -self.up_rad}  # positive: nose down
        return [("cmd_vel", self.steering.command()), ("cmd_tilt", tilt), *drop]

    def choose(self):
        """Return the points to fly to next."""
        x, y, _, _ = self.steering.pose
        if self.looking:
            return [(x, y, DEPTH_M, self.looking.pop(0))]
        if self.passed == 4:
            return self.later.pop(0)() if self.later else []
        opening = self.opening()
        if opening is None:
            self.looked += 1
            side = 0.5 if self.looked % 2 else -0.5
            self.looking = [0.6, -0.6, 0.0]
            return [(x + (0.0 if self.passed else 0.4), y + side, DEPTH_M, 0.0)]
        (ax, ay), (bx, by) = opening  # from starboard to port: its normal points ahead
        width = math.dist(*opening)
        nx, ny = (by - ay) / width, (ax - bx) / width
        mx, my, heading = 0.5 * (ax + bx), 0.5 * (ay + by), math.atan2(ny, nx)
        self.log(f"opening {self.passed} at {mx:.2f}, {my:.2f}, heading {math.degrees(heading):.0f} degrees")
        self.passed += 1
        self.looking = [0.6, -0.6, 0.0]
        return [(mx + d * nx, my + d * ny, DEPTH_M, heading) for d in (-0.9, 0.5)]

    def to_bin(self):
        """Return the points to the west of the bin, where the head tilts down."""
        self.up_rad = -0.5 * math.pi
        return [(BIN_M[0] - 1.0, BIN_M[1], OVER_M, 0.0, TILT_S)]

    def over_bin(self):
        """Return the point to the east of it."""
        self.echoes.clear()
        return [(BIN_M[0] + 0.6, BIN_M[1], OVER_M, 0.0)]

    def above_bin(self):
        """Return the points from which a marker falls into the middle of what has been seen."""
        if not self.echoes:
            return []
        x, y = (0.5 * (min(each) + max(each)) for each in zip(*self.echoes, strict=True))
        self.log(f"bin at {x:.2f}, {y:.2f}")
        return [(x - DROPPER_M, y, DROP_M, 0.0, 2.0)]

    def to_octagon(self):
        """Drop a marker, and return the points from which the octagon is looked for, with the head tilted up."""
        self.drops, self.up_rad = int(bool(self.echoes)), UP_RAD
        self.echoes.clear()
        turns = [(6.2 + d, 0.0, SHALLOW_M, a) for d in (0.0, 0.5, 1.0) for a in (-0.5, 0.0, 0.5)]
        return [(*self.steering.pose[:2], SHALLOW_M, 0.0, 1.2 * TILT_S), *turns]

    def in_octagon(self):
        """Return the points below and in the middle of the octagon."""
        side = self.octagon()
        self.log(f"octagon at {side:.2f}, from {len(self.echoes)} echoes")
        return [(OCTAGON_X_M, side, SHALLOW_M, 0.0), (OCTAGON_X_M, side, -0.1, 0.0)]

    def opening(self):
        """Return the two posts between which to pass, from starboard to port, or None."""
        posts = self.posts.sure(self.steering.pose[0] + 0.2)
        if self.passed == 0:  # the starboard half of the gate
            gates = []
            for a in posts:
                for b in posts:
                    middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))
                    is_wide = b[1] > a[1] and abs(math.dist(a, b) - GATE_M) < 0.25 and abs(b[0] - a[0]) < 1.4
                    if is_wide and middle[0] < GATE_X_M:
                        gates.append((middle[0], a, middle))
            return min(gates)[1:] if gates else None
        rows = []
        for a in posts:
            for b in posts:
                for c in posts:
                    even = abs(math.dist(a, b) - ROW_M) < 0.2 and abs(math.dist(b, c) - ROW_M) < 0.2
                    if even and a[1] < b[1] < c[1] and abs(math.dist(a, c) - 2.0 * ROW_M) < 0.2:
                        rows.append((b[0], a, b))
        return min(rows)[1:] if rows else None

    def octagon(self):
        """Return the y of the octagon's middle: the one for which most echoes are where its pipes would be."""

        def fitting(y_m):
            return sum(PIPES_M[0] < math.dist(pipe, (OCTAGON_X_M, y_m)) < PIPES_M[1] for pipe in self.echoes)

        return max((0.05 * k for k in range(-45, 46)), key=fitting)
