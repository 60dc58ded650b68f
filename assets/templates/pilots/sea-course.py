"""The team's pilot: a plain class, which a ROS 2 node (node.py) and the simulator without ROS (simulated.py) drive.

It flies lanes over the area with the sonar tilted down, which maps the bed. Echoes well above the bed are a buoy if
they stay together, and the pipes if they stretch. Then it looks at each buoy from near by, and at the pipes from both
sides. Of two buoys in its pictures the less yellow one is red: it notes that one, and looks at the other once more if
that came first. Change it as you like; what the drivers use is READS, WRITES, `receive` and `commands`.
"""

import base64
import math

from pilot.steering import Steering, turn

CAMERA = "camera/front/image_raw"
READS = {
    "odom": "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
    CAMERA: "sensor_msgs/msg/Image",
}
WRITES = {"cmd_vel": "geometry_msgs/msg/Twist", "cmd_tilt": "std_msgs/msg/Float64"}

SONAR_M, TILT_RAD = (0.24, -0.06), math.radians(30.0)  # the sonar's place ahead and above, and its tilt, nose down
BED_M, TALL_M, RANGE_M = 5.0, 1.06, 5.5  # the water's depth, the height above the bed that counts, the farthest echo
SAME_M, FEW = 0.6, 6  # distance that joins two echoes to one thing, and the fewest echoes of a thing
LONG_M = 0.7  # a thing with echoes farther from its middle than this is the pipes
AREA_M, LANES_M = 6.0, (-6.0, -2.0, 2.0, 6.0)  # half of the lanes' length, and where they are, as the rules state
CRUISE_M, SPEED_M_S, TURN_RAD_S = 2.2, 0.5, 0.5  # depth of the lanes, greatest speeds
BUOY_M, PIPES_M = (1.1, 3.9), (1.45, 4.2)  # distance and depth from which to look
LOOK_S, STILL_S = 5.5, 1.0  # longer than pictures are apart, and the time after which one counts


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


def yellowness(image):
    """Return by how much green exceeds blue in the yellowest of 200 points of the middle of a picture (rgb8).

    Red light is lost on its way through turbid water, blue is not in a yellow buoy.
    """
    data = base64.b64decode(image.data) if isinstance(image.data, str) else bytes(image.data)
    rows = range(int(0.28 * image.height), int(0.72 * image.height), 2)
    columns = range(int(0.34 * image.width), int(0.66 * image.width), 2)
    pixels = (row * image.step + 3 * column for row in rows for column in columns)
    found = sorted(data[k + 1] - data[k + 2] for k in pixels)
    return found[-len(found) // 200]


class Pilot:
    """Maps, finds, and looks. log: called with what it decides."""

    def __init__(self, log=print):
        self.log = log
        self.steering = Steering(SPEED_M_S, TURN_RAD_S)
        self.echoes = set()  # of what stands on the bed: (x, y), to 5 cm
        self.stage = 0
        self.yellow = {}  # how yellow each buoy is, by its place, in the order of the looks
        self.notes = []  # of what has been found, still to be sent

    def receive(self, topic, message):
        """Take a message of one of READS."""
        if topic == "odom":
            self.steering.see(message)
        elif topic == CAMERA:
            self.look_at(message)
        elif self.stage == 1 and self.steering.is_steady:
            self.see(message)

    def look_at(self, image):
        """Keep how yellow the buoy is before which the vehicle stays."""
        buoy = self.steering.way[0][5:] if self.steering.way else ()
        if buoy and self.steering.stayed_s > STILL_S:
            self.yellow[buoy] = max(self.yellow.get(buoy, -255), yellowness(image))

    def see(self, scan):
        """Keep the scan's echoes that are well above the bed."""
        for k, r in enumerate(scan.ranges):
            if not r or not scan.range_min < r < RANGE_M:
                continue
            beam = scan.angle_min + k * scan.angle_increment
            ahead, left = r * math.cos(beam), r * math.sin(beam)
            down = SONAR_M[1] - ahead * math.sin(TILT_RAD)
            x, y, z = self.steering.world(SONAR_M[0] + ahead * math.cos(TILT_RAD), left, down)
            if TALL_M - BED_M < z < -0.5 - CRUISE_M:
                self.echoes.add((round(20 * x) / 20, round(20 * y) / 20))

    def commands(self):
        """Return the messages to publish now, a list of pairs of a topic and plain values."""
        if self.steering.pose is None:
            return []
        if not self.steering.way:
            self.choose()
        notes, self.notes = self.notes, []
        return [("cmd_vel", self.steering.command()), ("cmd_tilt", {"data": TILT_RAD}), *notes]

    def choose(self):
        """Choose where to fly to next: the lanes, then what they have shown, then nowhere."""
        x, y, _, yaw = self.steering.pose
        self.stage += 1
        if self.stage == 1:
            for k, lane in enumerate(LANES_M):
                ends = (-AREA_M, AREA_M) if k % 2 == 0 else (AREA_M, -AREA_M)
                heading = 0.0 if k % 2 == 0 else math.pi
                self.steering.way += [(end, lane, CRUISE_M, heading, 0.0) for end in ends]
        elif self.stage == 2:
            buoys = []
            for group in things(self.echoes):
                at = middle(group)
                far = max(group, key=lambda echo: math.dist(echo, at))
                self.log(f"{len(group)} echoes at {at[0]:.2f}, {at[1]:.2f}, {math.dist(far, at):.2f} m around")
                if math.dist(far, at) < LONG_M:
                    buoys.append(at)
                    continue
                along = math.atan2(far[1] - at[1], far[0] - at[0])
                for side in (0.5 * math.pi, -0.5 * math.pi):
                    self.look(at, along + side, *PIPES_M)
            for at in buoys:
                self.look(at, math.atan2(y - at[1], x - at[0]), *BUOY_M, of=at)
        elif self.stage == 3 and self.yellow:
            self.log(f"how yellow: {self.yellow}")
            red, *others = sorted(self.yellow, key=self.yellow.get)
            place = [*red, 1.1 - BED_M]
            self.notes = [("note", {"text": "red buoy", "category": "observation", "position_world_m": place})]
            if others and next(iter(self.yellow)) != red:  # the yellow one counts once the red one has been looked at
                self.look(others[-1], math.atan2(y - others[-1][1], x - others[-1][0]), *BUOY_M)
        if not self.steering.way:
            self.steering.way = [(x, y, CRUISE_M, yaw, 10.0)]

    def look(self, at, direction_rad, distance_m, depth_m, of=()):
        """Add the way to where a place is seen from a direction, from above and up again."""
        x, y = at[0] + distance_m * math.cos(direction_rad), at[1] + distance_m * math.sin(direction_rad)
        heading = turn(direction_rad + math.pi)
        self.steering.way += [
            (x, y, CRUISE_M, heading, 0.0),
            (x, y, depth_m, heading, LOOK_S, *of),
            (x, y, CRUISE_M, heading, 0.0),
        ]
