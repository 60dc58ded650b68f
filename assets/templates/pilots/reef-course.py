"""The team's pilot: a plain class, which a ROS 2 node (node.py) and the simulator without ROS (simulated.py) drive.

It flies lanes over the area with the sonar tilted down, and the camera at the bed. Echoes above the bed are the console
where they are tall, the plate where they are wide, else coral. Then it looks down at the coral on both sides of the
line, the first twice, since a sonar does not show which end is west, and at the console from both sides, and stays
over the plate. It notes the coral and the console. Change it as you like; what the drivers use is READS, WRITES,
`receive` and `commands`.
"""

import math

from pilot.steering import Steering, turn

READS = {"odom": "nav_msgs/msg/Odometry", "scan": "sensor_msgs/msg/LaserScan"}
WRITES = {"cmd_vel": "geometry_msgs/msg/Twist", "cmd_tilt": "std_msgs/msg/Float64",
          "camera/front/cmd_tilt": "std_msgs/msg/Float64"}  # fmt: skip

SONAR_M, TILT_RAD = (0.24, -0.06), math.radians(30.0)  # the sonar's place ahead and above, and its tilt, nose down
BED_M, ABOVE_M, RANGE_M = 5.0, 0.15, 4.8  # the water's depth, the height above the bed that counts, the farthest echo
SAME_M, FEW = 0.45, 8  # distance that joins two echoes to one thing, and the fewest echoes of a thing
TALL_M, BOX_M, WIDE_M = 1.2, 0.8, 0.45  # heights of the console and of what is none of ours, and half the plate's width
AREA_M, LANES_M = 6.0, (-4.5, -1.5, 1.5, 4.5)  # half of the lanes' length, and where they are, as the rules state
CRUISE_M, SPEED_M_S, TURN_RAD_S = 3.0, 0.5, 0.5  # depth of the lanes, greatest speeds
CONSOLE_M, PLATE_M = (1.4, 3.9), 4.0  # distance and depth from which to look, and depth over the plate
LOOK_S, STAY_S = 3.5, 12.0
DOWN_RAD, AHEAD_RAD = 1.3, 0.0  # the camera's tilt over the bed, and before the console


def things(echoes):
    """Return echoes (x, y) as lists of those that are near to each other, the largest first."""
    left, found = list(echoes), []
    while left:
        group, edge = [], [left.pop()]
        while edge:
            one = edge.pop()
            group.append(one)
            edge += [other for other in left if math.dist(one, other) < SAME_M]
            left = [other for other in left if math.dist(one, other) >= SAME_M]
        if len(group) >= FEW:
            found.append(group)
    return sorted(found, key=len, reverse=True)


def middle(points):
    """Return the middle of the box around points (x, y)."""
    return tuple(0.5 * (min(p[k] for p in points) + max(p[k] for p in points)) for k in (0, 1))


class Pilot:
    """Maps, finds, and looks. log: called with what it decides."""

    def __init__(self, log=print):
        self.log = log
        self.steering = Steering(SPEED_M_S, TURN_RAD_S)
        self.echoes = {}  # the height of what stands on the bed, by (x, y), to 5 cm
        self.stage = 0
        self.notes = []  # of what has been found, still to be sent

    def receive(self, topic, message):
        """Take a message of one of READS."""
        if topic == "odom":
            self.steering.see(message)
        elif self.stage == 1 and self.steering.is_steady:
            self.see(message)

    def see(self, scan):
        """Keep the scan's echoes that are well above the bed."""
        for k, r in enumerate(scan.ranges):
            if not r or not scan.range_min < r < RANGE_M:
                continue
            beam = scan.angle_min + k * scan.angle_increment
            ahead, left = r * math.cos(beam), r * math.sin(beam)
            down = SONAR_M[1] - ahead * math.sin(TILT_RAD)
            x, y, z = self.steering.world(SONAR_M[0] + ahead * math.cos(TILT_RAD), left, down)
            if ABOVE_M < z + BED_M < BED_M - CRUISE_M - 0.3:
                at = (round(20 * x) / 20, round(20 * y) / 20)
                self.echoes[at] = max(self.echoes.get(at, 0.0), z + BED_M)

    def commands(self):
        """Return the messages to publish now, a list of pairs of a topic and plain values."""
        if self.steering.pose is None:
            return []
        if not self.steering.way:
            self.choose()
        tilt_rad = self.steering.way[0][-1]
        tilts = [("cmd_tilt", {"data": TILT_RAD}), ("camera/front/cmd_tilt", {"data": tilt_rad})]
        notes, self.notes = self.notes, []
        return [("cmd_vel", self.steering.command()), *tilts, *notes]

    def choose(self):
        """Choose where to fly to next: the lanes, then what they have shown, then nowhere."""
        x, y, _, yaw = self.steering.pose
        self.stage += 1
        if self.stage == 1:
            for k, lane in enumerate(LANES_M):
                ends = (-AREA_M, AREA_M) if k % 2 == 0 else (AREA_M, -AREA_M)
                heading = 0.0 if k % 2 == 0 else math.pi
                self.steering.way += [(end, lane, CRUISE_M, heading, 0.0, DOWN_RAD) for end in ends]
        elif self.stage == 2:
            coral, plate = [], []
            for group in things(self.echoes):
                at, tall = middle(group), max(self.echoes[echo] for echo in group)
                far = max(group, key=lambda echo: math.dist(echo, at))
                size = f"{math.dist(far, at):.2f} m around, {tall:.2f} m tall"
                self.log(f"{len(group)} echoes at {at[0]:.2f}, {at[1]:.2f}, {size}")
                if tall > TALL_M:
                    self.note("console", "observation", at, tall - BED_M - 0.5)
                    along = math.atan2(far[1] - at[1], far[0] - at[0])
                    for side in (0.5 * math.pi, -0.5 * math.pi):
                        self.look(at, along + side, *CONSOLE_M)
                elif tall < BOX_M and math.dist(far, at) > WIDE_M:
                    plate += group  # its two guides are two groups
                elif tall < BOX_M:
                    coral.append(at)
                    self.note("coral", "growth", at, 0.2 - BED_M)
            for at in coral + coral[:-1]:
                self.steering.way.append((*at, CRUISE_M, 0.0, LOOK_S, DOWN_RAD))
            if plate:
                stops = ((CRUISE_M, 0.0), (PLATE_M, STAY_S), (CRUISE_M, 0.0))
                self.steering.way += [(*middle(plate), depth, 0.0, stay_s, DOWN_RAD) for depth, stay_s in stops]
        if not self.steering.way:
            self.steering.way = [(x, y, CRUISE_M, yaw, 10.0, DOWN_RAD)]

    def note(self, text, category, at, z_m):
        """Note what stands at a place."""
        self.notes.append(("note", {"text": text, "category": category, "position_world_m": [*at, z_m]}))

    def look(self, at, direction_rad, distance_m, depth_m):
        """Add the way to where a place is seen from a direction, from above and up again."""
        x, y = at[0] + distance_m * math.cos(direction_rad), at[1] + distance_m * math.sin(direction_rad)
        heading = turn(direction_rad + math.pi)
        stops = ((CRUISE_M, 0.0), (depth_m, LOOK_S), (CRUISE_M, 0.0))
        self.steering.way += [(x, y, depth, heading, stay_s, AHEAD_RAD) for depth, stay_s in stops]
