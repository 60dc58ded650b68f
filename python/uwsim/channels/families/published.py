"""The protocol of the paper's simulator: topics and strings in the format that its nodes expect.

Strings contain numbers in C#'s format, with up to seven significant digits, each followed by the letter a.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from uwsim.channels.authority.steering import Steering
from uwsim.channels.channel import COMMAND, LATCHED, LATE, PANEL, PICTURE, Authority, Channel, OverLink
from uwsim.channels.delivery.pictures import RATE_HZ, Pictures
from uwsim.channels.families.cameras import jpeg_message
from uwsim.channels.families.key import POSE, Function, key_efforts
from uwsim.channels.families.pings import Pings
from uwsim.channels.families.scans import DEPTH_ARRAY
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.channels.taped import of_motion
from uwsim.live import LiveSimulator
from uwsim.mapping import ranging
from uwsim.navigation.sensor_choice import port_proximity
from uwsim.simulator.simulator import Simulator

POSE_HZ = 50.0
PANEL_HZ = 10.0
SLOW_HZ = 1.0
TEXT, JPEG = "std_msgs/msg/String", "sensor_msgs/msg/CompressedImage"
CAMERA_FRAME = "camera"
TRUE_TOPICS = ("propPos", "stateData")
"""Name endings of topics that carry the truth, as in the published simulator."""
TILT_LIMIT_RAD = 0.5 * math.pi


def csharp_number(value: float) -> str:
    """Return a float32 in C#'s default format: "12.31", "1E-05", "Infinity"."""
    single = float(np.float32(value))
    if math.isinf(single):
        return "Infinity" if single > 0 else "-Infinity"
    return f"{single:.7g}".replace("e", "E")


def join(values: Iterable[float]) -> str:
    """Return the numbers as text, each followed by the letter a."""
    return "".join(csharp_number(value) + "a" for value in values)


def state_text(sim: Simulator, source: Source) -> str:
    """Return the text of `stateData`, the nine values on the panel. An infinite distance is "Infinity".

    As in the published simulator, the mission time counts whole seconds from the start of the scene. The battery's
    charge is the simulated vehicle's and starts to fall at its release.
    """
    panel = source.of(sim).telemetry()
    return join(
        [
            panel.speed_m_s,
            panel.angular_speed_rad_s,
            panel.temperature_deg_c,
            1e-3 * panel.pressure_pa,
            panel.depth_m,
            panel.distance_to_station_m,
            panel.distance_to_seabed_m,
            float(sim.time_ns // 1_000_000_000),
            panel.battery_percent,
        ]
    )


def published_channels(
    source: Source, sim: Simulator, pings: Pings | None, pictures: Pictures, steering: Steering
) -> list[Channel]:
    """Return a vehicle's published topics. depthArray exists only for the protocol's four sonar models."""
    topic, vehicle = source.topic, source.of(sim)
    found = [
        Channel(
            topic("propPos"), POSE, "out", "pose, odom -> base_footprint", rate_hz=POSE_HZ,
            frame_id=source.frame("odom"), over_link=OverLink(PANEL, "pose"),
            **of_motion(source, lambda at: build.pose(at.position_m + source.origin_m, at.orientation_xyzw)),
        ),
        Channel(
            topic("stateData"), TEXT, "out",
            "speed [m/s], angular speed [rad/s], temperature [deg C], pressure [kPa], depth [m], distances to station "
            "and seabed [m], whole seconds since the start of the scene, battery [%], each followed by a",
            rate_hz=PANEL_HZ, over_link=OverLink(PANEL, "state"),
            read=lambda sim: build.text(state_text(sim, source)),
        ),
        Channel(
            topic("key"), POSE, "in",
            "efforts, saturating at +-1: position surge, sway (starboard), heave; orientation x, y, z pitch, roll, yaw "
            "(starboard); w: 1 release, 2/3 front light off/on, 4/5 down light off/on, 6/7/8 tilt down/hold/up",
            over_link=OverLink(COMMAND, "key"),
            apply=lambda live, message: apply_key(live, source, steering, message),
            authority=Authority(abandoned=lambda live: _abandon_key(live, steering)),
        ),
    ]  # fmt: skip
    if (to_port := port_proximity(vehicle.sensors)) is not None:
        port = to_port.name
        found.append(
            Channel(
                topic("proximitySensor"), TEXT, "out", "distance to port [m], 10 at most", rate_hz=PANEL_HZ,
                over_link=OverLink(),
                read=lambda sim: build.text(csharp_number(_number(source.of(sim).sensors[port].read()))),
            )
        )  # fmt: skip
    if pings is not None:
        found += _sonar_channels(source, pings)
    return found + _picture_channels(source, sim, pictures)


def _number(value: Any) -> float:
    return float(value)


def _sonar_channels(source: Source, pings: Pings) -> list[Channel]:
    topic = source.topic
    found = [
        Channel(
            topic("scanPos"), POSE, "out", "the sonar's head, base_footprint -> base_scan", rate_hz=POSE_HZ,
            frame_id=source.frame("base_footprint"), over_link=OverLink(packing="pose"),
            **of_motion(source, lambda at: build.pose(source.scan_mount_m, at.tilt_xyzw)),
        ),
        Channel(
            topic("hFOV"), TEXT, "out", "the sonar's field of view [deg]", rate_hz=SLOW_HZ, delivery=LATCHED,
            over_link=OverLink(), read=lambda sim: build.text(csharp_number(_fov_deg(source, sim))),
        ),
    ]  # fmt: skip
    if pings.model.number not in ranging.MODELS:
        return found
    return [
        *found,
        Channel(
            topic("modelTrigger"), TEXT, "out", "the sonar's model, 1 to 4", rate_hz=SLOW_HZ, delivery=LATCHED,
            over_link=OverLink(), read=lambda sim: _model_number(source, sim),
        ),
        DEPTH_ARRAY.channel(source, pings),
    ]  # fmt: skip


def _model_number(source: Source, sim: Simulator) -> Any:
    number = source.of(sim).sonar.model.number
    return build.text(str(number)) if number in ranging.MODELS else None  # parameters may change the model


def _fov_deg(source: Source, sim: Simulator) -> float:
    return math.degrees(source.of(sim).sonar.model.field_of_view_rad)


def _picture_channels(source: Source, sim: Simulator, pictures: Pictures) -> list[Channel]:
    found = []
    cameras = [name for name, camera in source.of(sim).cameras.items() if camera.mount.follows == "body"]
    if cameras:
        found.append(
            Channel(
                source.topic("images/compressed"), JPEG, "out",
                "the vehicle's cameras in turn, distinguished by frame_id", rate_hz=RATE_HZ * len(cameras),
                over_link=OverLink(PICTURE, "thumbnail"), delivery=LATE,
                read=lambda sim: _next_picture(source, pictures, cameras, sim),
            )
        )  # fmt: skip
    return found


def station_picture(pictures: Pictures, sim: Simulator, frame_prefix: str = "") -> list[Channel]:
    """Return the channel of the published picture, which is from the deck camera or else from the first camera."""
    if not sim.cameras:
        return []
    name = "deck" if "deck" in sim.cameras else next(iter(sim.cameras))
    frame_id = f"{frame_prefix}{CAMERA_FRAME}"

    def read(sim: Simulator) -> Any:
        picture = pictures.read(sim, name, sim.cameras[name])
        return None if picture is None else jpeg_message(picture, frame_id, "jpeg")

    return [
        Channel(
            "image/compressed", JPEG, "out", "the station's camera", rate_hz=RATE_HZ, frame_id=frame_id,
            delivery=LATE, read=read,
        )
    ]  # fmt: skip


def _next_picture(source: Source, pictures: Pictures, cameras: Sequence[str], sim: Simulator) -> Any:
    turn = int(sim.time_ns * RATE_HZ * len(cameras) // 1_000_000_000) % len(cameras)
    name = cameras[turn]
    picture = pictures.read(sim, source.topic(name), source.of(sim).cameras[name])
    return None if picture is None else jpeg_message(picture, source.frame(f"{name}_optical"), "jpeg")


def apply_key(live: LiveSimulator, source: Source, steering: Steering, message: Any) -> None:
    """Apply a published `key` message, all of it or, raising ValueError, none of it."""
    efforts, function = key_efforts(message), message.orientation.w
    for axis, effort in efforts.items():
        if math.isnan(effort):
            raise ValueError(f"key: {axis} effort = {effort}: must be a number")
    functions = _functions(live, source)
    if function not in (Function.NONE, *functions):
        raise ValueError(f"key: orientation.w = {function:g}: must be a function, 0 to {len(functions)}")
    saturated = {axis: min(max(float(effort), -1.0), 1.0) for axis, effort in efforts.items()}
    steering.give(live, "set_effort", **saturated)
    steering.by_keys = any(saturated.values())
    if function:
        name, arguments = functions[int(function)]
        if name:
            steering.ask(live, name, **arguments)


def _abandon_key(live: LiveSimulator, steering: Steering) -> None:
    """Set efforts to zero if they came from the keyboard. Called when the keyboard has disconnected."""
    if steering.by_keys:
        steering.give(live, "set_effort")


def _functions(live: LiveSimulator, source: Source) -> dict[int, tuple[str, dict[str, Any]]]:
    """Return the command of each function, or "" if the vehicle lacks the required part and ignores the key."""
    vehicle = source.of(live.simulator)

    def lamp(name: str, on: bool) -> tuple[str, dict[str, Any]]:
        return ("set_lamp", {"lamp": name, "on": on}) if name in vehicle.lamps else ("", {})

    def aim(elevation_rad: float) -> tuple[str, dict[str, Any]]:
        return ("aim", {"elevation_rad": elevation_rad}) if source.has_sonar else ("", {})

    return {
        Function.RELEASE: ("release", {}),
        Function.FRONT_OFF: lamp("front", False),
        Function.FRONT_ON: lamp("front", True),
        Function.DOWN_OFF: lamp("down", False),
        Function.DOWN_ON: lamp("down", True),
        Function.TILT_DOWN: aim(-TILT_LIMIT_RAD),
        Function.TILT_HOLD: aim(vehicle.sonar.elevation_rad if source.has_sonar else 0.0),
        Function.TILT_UP: aim(TILT_LIMIT_RAD),
    }
