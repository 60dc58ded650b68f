"""The team's pilot: a plain class, which a ROS 2 node (node.py) and the simulator without ROS (simulated.py) drive.

It maps the bed along three lanes with the sonar looking down. Then it looks for each thing near where the rules place
it, in a level scan, and stops before it with the camera ahead: two buoys, then the pipes. Change it as you like; what
the drivers use is READS, WRITES, PERIOD_S, `receive` and `commands`.
"""

import math

from pilot.steering import Steering

READS = {"odom": "nav_msgs/msg/Odometry", "scan": "sensor_msgs/msg/LaserScan"}
WRITES = {"cmd_vel": "geometry_msgs/msg/Twist", "cmd_tilt": "std_msgs/msg/Float64"}
PERIOD_S = 0.1

SONAR_M = (0.24, -0.06)  # the sonar's place ahead of and above the vehicle's origin
LANES_M = [(-6.8, -4.7, 6.8), (6.8, 0.0, -4.0), (-6.8, 4.7, 6.8)]  # x, y, x: that in the middle ends before the station
LANE_DEPTH_M, ABOVE_M = 1.7, 2.3  # of the lanes, and of the ways from one thing to the next, above them all
BUOYS_M = [(-1.0, -6.0), (4.0, -5.0)]  # as the rules state, within a metre: the red one first
BUOY_DEPTH_M, BUOY_RADIUS_M = 3.83, 0.115
PIPES_M, PIPE_DEPTH_M, LOW_M = (5.0, 3.0), 3.74, 4.3  # the upper pipe's depth, and one from which the lower is seen
PLAY_M, SPAN_M = 1.3, 2.0  # how far from there things may be, and the length of the pipes
AWAY_M, BEFORE_M = 2.9, 1.2  # where a thing is looked for, and where it is looked at
STAY = 40  # periods for which it is looked at
DOWN_RAD, LEVEL_RAD, TURNING_RAD_S = math.radians(90.0), 0.0, math.radians(5.0)  # the head's tilt, and its rate


class Pilot:
    """Flies the lanes, then from thing to thing. log: called with what it decides."""

    def __init__(self, log=print):
        self.log = log
        self.steering = Steering()
        self.tilt_rad = DOWN_RAD
        self.echoes = []  # of a level scan: (x, y) in the frame of odom
        self.steps = [
            self.map_bed,
            self.level,
            *[lambda at=at: self.find(at, BUOY_DEPTH_M, self.see_buoy) for at in BUOYS_M],
        ]
        self.steps.append(lambda: self.find(PIPES_M, PIPE_DEPTH_M, self.see_pipes))

    def receive(self, topic, message):
        """Take a message of one of READS."""
        if topic == "odom":
            self.steering.see(message)
        elif self.steering.pose is not None and self.steering.is_steady and self.tilt_rad == LEVEL_RAD:
            x, y, _, yaw = self.steering.pose
            x, y = x + SONAR_M[0] * math.cos(yaw), y + SONAR_M[0] * math.sin(yaw)
            for k, r in enumerate(message.ranges):
                if r and message.range_min < r < message.range_max:
                    bearing = yaw + message.angle_min + k * message.angle_increment
                    self.echoes.append((x + r * math.cos(bearing), y + r * math.sin(bearing)))

    def commands(self):
        """Return the messages to publish now, a list of pairs of a topic and plain values."""
        if self.steering.pose is None:
            return []
        if not self.steering.way and self.steps:
            self.steps.pop(0)()
        return [("cmd_vel", self.steering.command()), ("cmd_tilt", {"data": self.tilt_rad})]

    def fly(self, x_m, y_m, depth_m, heading_rad, periods=1):
        """Fly to a point by way of the water above all things, and stay there."""
        x, y, _, yaw = self.steering.pose
        way = [(x, y, ABOVE_M, yaw), (x_m, y_m, ABOVE_M, heading_rad)]
        self.steering.way += [*way, *[(x_m, y_m, depth_m, heading_rad)] * periods]

    def map_bed(self):
        """Fly the lanes with the fan across them, ahead and astern, without turning."""
        x, y, _, _ = self.steering.pose
        self.steering.way = [(x, y, LANE_DEPTH_M, 0.0)] * round((DOWN_RAD / TURNING_RAD_S) / PERIOD_S)
        for begin, y, end in LANES_M:
            self.steering.way += [(begin, y, LANE_DEPTH_M, 0.0), (end, y, LANE_DEPTH_M, 0.0)]

    def level(self):
        """Tilt the head back, on the way to the first buoy."""
        self.tilt_rad = LEVEL_RAD
        self.fly(BUOYS_M[0][0] - AWAY_M, BUOYS_M[0][1], BUOY_DEPTH_M, 0.0, round(DOWN_RAD / TURNING_RAD_S / PERIOD_S))

    def find(self, at_m, depth_m, see):
        """Fly to where a thing is in the fan wherever it may be, and look at it from nearer."""
        self.fly(at_m[0] - AWAY_M, at_m[1], depth_m, 0.0, periods=15)
        self.steps.insert(0, lambda: self.listen(at_m, see))

    def listen(self, at_m, see):
        """Stay for some scans, then look at what they show near a place."""
        self.echoes.clear()
        self.steering.way = [self.steering.last] * 15
        self.steps.insert(0, lambda: see([echo for echo in self.echoes if math.dist(echo, at_m) < PLAY_M + SPAN_M / 2]))

    def see_buoy(self, echoes):
        """Stop before the middle of the echoes."""
        if not echoes:
            self.log("no buoy is there")
            return
        x, y = (sum(each) / len(echoes) for each in zip(*echoes, strict=True))
        self.log(f"buoy at {x:.2f}, {y:.2f}")
        self.steering.way = [(x - BEFORE_M, y, BUOY_DEPTH_M, 0.0)] * STAY

    def see_pipes(self, echoes):
        """Stop before the middle of the upper pipe, square to it, then lower."""
        if len(echoes) < 2:
            self.log("no pipes are there")
            return
        south, north = min(echoes, key=lambda echo: echo[1]), max(echoes, key=lambda echo: echo[1])
        x, y = 0.5 * (south[0] + north[0]), 0.5 * (south[1] + north[1])
        heading = math.atan2(south[0] - north[0], north[1] - south[1])
        self.log(f"pipes at {x:.2f}, {y:.2f}, heading {math.degrees(heading):.0f} degrees")
        x, y = x - BEFORE_M * math.cos(heading), y - BEFORE_M * math.sin(heading)
        self.steering.way = [(x, y, depth, heading) for depth in (PIPE_DEPTH_M, LOW_M) for _ in range(STAY)]
