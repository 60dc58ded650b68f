"""A flight of a known model, written as the logs of others are: telemetry, dataflash, table, bag."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim import Batch
from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU, euler_rad
from uwsim.recording.real_flights.deep_water import STEP_S, in_deep_water
from uwsim.recording.real_flights.frames import servo_motors
from uwsim.scenario import load_vehicle

VEHICLE, FRAME, DENSITY_KG_M3 = "bluerov2_heavy", "vectored_6dof", 1026.0
ROW_STEPS, ROWS, HELD = 4, 1000, 40  # a row every 20 ms for 20 s; commands are held for 0.8 s
STAMP_S = 1_700_000_000.0
FLAGS = 0x33F  # EKF_STATUS_FLAGS: all is known
FORMATS: Mapping[str, tuple[str, list[str]]] = {
    "FMT": ("BBnNZ", ["Type", "Length", "Name", "Format", "Columns"]),
    "PARM": ("QNf", ["TimeUS", "Name", "Value"]),
    "MSG": ("QZ", ["TimeUS", "Message"]),
    "RCOU": ("Q" + "H" * 14, ["TimeUS", *(f"C{n}" for n in range(1, 15))]),
    "ATT": ("Qfff", ["TimeUS", "Roll", "Pitch", "Yaw"]),
    "IMU": ("QBfff", ["TimeUS", "I", "GyrX", "GyrY", "GyrZ"]),
    "XKF1": ("QBffffff", ["TimeUS", "C", "VN", "VE", "VD", "PN", "PE", "PD"]),
    "XKF4": ("QBI", ["TimeUS", "C", "SS"]),
    "CTUN": ("Qf", ["TimeUS", "Alt"]),
}
WIDTHS = {"B": "B", "H": "H", "I": "I", "Q": "Q", "f": "f", "n": "4s", "N": "16s", "Z": "64s"}
PARAMETERS = {
    "FRAME_CONFIG": 2.0,
    "MOT_PWM_MIN": 1100.0,
    "MOT_PWM_MAX": 1900.0,
    "MOT_1_DIRECTION": -1.0,
    **{f"SERVO{k}_FUNCTION": 32.0 + k for k in range(1, 9)},
}


@dataclass(frozen=True)
class Flown:
    """Times (n,), motion in the project's axes, and pulse widths (n, 8) of the frame's outputs from each row on."""

    times_s: NDArray[np.float64]
    position_m: NDArray[np.float64]
    orientation_xyzw: NDArray[np.float64]
    velocity_body: NDArray[np.float64]
    pulses_us: NDArray[np.int64]

    def ned(self, k: int) -> tuple[Any, Any, Any, Any]:
        """Roll, pitch, yaw [rad], rates, velocity and position of a row in an autopilot's axes."""
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_quat(self.orientation_xyzw[k]).as_matrix()
        velocity = NED_FROM_ENU @ (turn[:3, :3] @ self.velocity_body[k, :3])
        return euler_rad(turn), FRD * self.velocity_body[k, 3:], velocity, NED_FROM_ENU @ self.position_m[k]


@cache
def flown(commanded: bool = True) -> Flown:
    """Fly; commands change half-way between two rows."""
    model, draw = load_vehicle(VEHICLE), np.random.default_rng(7)
    motors = servo_motors(FRAME, model.thrusters, VEHICLE)
    rows = np.zeros((ROWS, 13))
    pulses = np.repeat(1500 + draw.integers(-160, 160, (ROWS // HELD, 8)) * commanded, HELD, axis=0)
    with TemporaryDirectory() as folder:
        batch = Batch(in_deep_water(model, DENSITY_KG_M3, Path(folder)), n=1)
        batch.place([[0.0, 0.0, -400.0]])
        for k in range(ROWS):
            batch.set_thrusters(
                {
                    each.thruster: each.direction
                    * (pulses[k, each.output] - 1500)
                    / 400.0
                    * (-1.0 if each.output == 0 else 1.0)
                    for each in motors
                }
            )
            batch.step(ROW_STEPS // 2)
            at = batch.observe()
            rows[k] = np.hstack([at.position_world_m[0], at.orientation_xyzw[0], at.velocity_body[0]])
            batch.step(ROW_STEPS // 2)
    times_s = 100.0 + ROW_STEPS * STEP_S * np.arange(ROWS)
    return Flown(times_s, rows[:, :3] - [0, 0, -405.0], rows[:, 3:7], rows[:, 7:], pulses)


def telemetry(
    flight: Flown, flags: int = FLAGS, bed: Callable[[Any], tuple[float, float, float]] | None = None
) -> bytes:
    """Write it as a ground station does, by pymavlink.

    bed: returns latitude, longitude and the bed's depth at a position; then also place and range below are written.
    """
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    mav = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    mav.robust_parsing = True
    messages = [
        (flight.times_s[0], mav.param_value_encode(name.encode(), value, 9, 100, k))
        for k, (name, value) in enumerate(PARAMETERS.items())
    ]
    messages.append((flight.times_s[0], mav.statustext_encode(6, b"ArduSub")))
    for k, time_s in enumerate(flight.times_s):
        ms = round(1e3 * time_s)
        angles, rates, velocity, position = flight.ned(k)
        messages += [
            (time_s, mav.attitude_encode(ms, *angles, *rates)),
            (time_s, mav.local_position_ned_encode(ms, *position, *velocity)),
            (time_s, mav.servo_output_raw_encode(1000 * ms % 2**32, 0, *map(int, flight.pulses_us[k]), *[0] * 8)),
            (time_s, mav.vfr_hud_encode(0, 0, 0, 0, -position[2], 0)),
            (time_s, mav.ekf_status_report_encode(flags, 0, 0, 0, 0, 0)),
        ]
        if bed is not None:
            lat, lon, depth_m = bed(flight.position_m[k])
            upright = float(Rotation.from_quat(flight.orientation_xyzw[k]).as_matrix()[2, 2])
            range_cm = round(100.0 * (depth_m - position[2]) / upright) if upright > 0.5 else 0
            messages += [
                (time_s, mav.global_position_int_encode(ms, round(1e7 * lat), round(1e7 * lon), 0, 0, 0, 0, 0, 65535)),
                (time_s, mav.distance_sensor_encode(ms, 20, 10000, range_cm, 0, 0, 25, 0)),
                (time_s, mav.distance_sensor_encode(ms, 20, 10000, 33, 0, 1, 0, 0)),  # ahead
            ]
    return b"".join(struct.pack(">Q", round(1e6 * (STAMP_S + time_s))) + each.pack(mav) for time_s, each in messages)


def dataflash(flight: Flown, status: int = FLAGS) -> bytes:
    """Write it as ArduSub does."""
    rows: list[tuple[str, list[Any]]] = [("PARM", [0, k.encode(), v]) for k, v in PARAMETERS.items()]
    rows.append(("MSG", [0, b"ArduSub V4.5"]))
    for k, time_s in enumerate(flight.times_s):
        us = round(1e6 * time_s)
        angles, rates, velocity, position = flight.ned(k)
        rows += [
            ("RCOU", [us, *flight.pulses_us[k], *[0] * 6]),
            ("ATT", [us, *np.degrees(angles)]),
            ("IMU", [us, 0, *rates]),
            ("IMU", [us, 1, 9, 9, 9]),
            ("XKF1", [us, 0, *velocity, *position]),
            ("XKF1", [us, 1, *[9] * 6]),
            ("XKF4", [us, 0, status]),
            ("CTUN", [us, -position[2]]),
        ]
    return binary_log(FORMATS, rows)


def binary_log(formats: Mapping[str, tuple[str, list[str]]], rows: list[tuple[str, list[Any]]]) -> bytes:
    """A dataflash log: each message is 0xA3, 0x95, its type, and its fields; FMT messages describe the types."""
    types = {name: 128 + k for k, name in enumerate(formats)}

    def packed(name: str, values: list[Any]) -> bytes:
        layout = "<" + "".join(WIDTHS[letter] for letter in formats[name][0])
        return bytes((0xA3, 0x95, types[name])) + struct.pack(layout, *values)

    def described(name: str) -> bytes:
        letters, columns = formats[name]
        length = 3 + struct.calcsize("<" + "".join(WIDTHS[letter] for letter in letters))
        texts = [name.encode(), letters.encode(), ",".join(columns).encode()]
        return packed("FMT", [types[name], length, *texts])

    return b"".join([*map(described, formats), *(packed(name, values) for name, values in rows)])


COLUMNS = (
    "t = time [ms], n = north [cm], e = east [m], d = depth [m], r = roll [deg], p = pitch [deg], "
    "h = heading [deg], u = surge [m/s], v = sway [m/s], w = heave [m/s], a = roll rate [deg/s], "
    "b = pitch rate [deg/s], c = yaw rate [deg/s], " + ", ".join(f"s{k} = servo{k} [us]" for k in range(1, 9))
)


def table(flight: Flown) -> bytes:
    """Write it as a table of mixed units."""
    lines = ["t,n,e,d,r,p,h,u,v,w,a,b,c," + ",".join(f"s{k}" for k in range(1, 9))]
    for k, time_s in enumerate(flight.times_s):
        angles, _, _, position = flight.ned(k)
        numbers = [
            1e3 * time_s,
            100 * position[0],
            position[1],
            position[2],
            *np.degrees(angles),
            *flight.velocity_body[k, :3],
            *np.degrees(flight.velocity_body[k, 3:]),
            *flight.pulses_us[k],
        ]
        lines.append(",".join(f"{number:.9g}" for number in numbers))
    return "\n".join(lines).encode() + b"\n"


def bag(flight: Flown, folder: Path) -> Path:
    """Write it as a bag of ROS 2: odometry, and commands in the order of the vehicle's file."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    t = store.types
    motors = servo_motors(FRAME, load_vehicle(VEHICLE).thrusters, VEHICLE)
    names = list(load_vehicle(VEHICLE).thrusters)
    output = {each.thruster: (each.output, each.direction * (-1.0 if each.output == 0 else 1.0)) for each in motors}

    def vector(kind: str, values: Any) -> Any:
        return t[f"geometry_msgs/msg/{kind}"](**dict(zip("xyzw", map(float, values), strict=False)))

    with Writer(folder, version=9) as writer:
        odometry = writer.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=store)
        thrusters = writer.add_connection("/thruster_cmds", "std_msgs/msg/Float64MultiArray", typestore=store)
        for k, time_s in enumerate(flight.times_s):
            ns = round(1e9 * time_s)
            stamp = t["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
            pose = t["geometry_msgs/msg/Pose"](
                position=vector("Point", flight.position_m[k]),
                orientation=vector("Quaternion", flight.orientation_xyzw[k]),
            )
            twist = t["geometry_msgs/msg/Twist"](
                linear=vector("Vector3", flight.velocity_body[k, :3]),
                angular=vector("Vector3", flight.velocity_body[k, 3:]),
            )
            message = t["nav_msgs/msg/Odometry"](
                header=t["std_msgs/msg/Header"](stamp=stamp, frame_id="odom"),
                child_frame_id="base_link",
                pose=t["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
                twist=t["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=np.zeros(36)),
            )
            writer.write(odometry, ns, store.serialize_cdr(message, "nav_msgs/msg/Odometry"))
            sent = [sign * (flight.pulses_us[k, at] - 1500) / 400.0 for at, sign in output.values()]
            order = dict(zip(output, sent, strict=True))
            data = np.array([order[name] for name in names])
            layout = t["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
            array = t["std_msgs/msg/Float64MultiArray"](layout=layout, data=data)
            writer.write(thrusters, ns, store.serialize_cdr(array, "std_msgs/msg/Float64MultiArray"))
    return folder
