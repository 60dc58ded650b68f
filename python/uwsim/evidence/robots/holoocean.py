"""Scenarios of HoloOcean (JSON): agents with their sensors and places.

Source: HoloOcean 2, documentation of scenarios, agents and sensors. Its world is north, west, up; its agents' axes are
forward, left, up. Worlds and agents are Unreal's: an agent is replaced by the packaged vehicle that resembles it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.texts.json_text import read_json
from uwsim.evidence.robots.robot import Found, Robot, plain_name
from uwsim.evidence.robots.sensors import put_camera, put_imaging
from uwsim.evidence.robots.xml_file import Pose, turned
from uwsim.scenario.spec.camera import LARGEST_SIDE

ENU_FROM_NWU = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
AGENTS = {
    "HoveringAUV": "bluerov2_heavy",
    "BlueROV2": "bluerov2_heavy",
    "TorpedoAUV": "remus100",
    "CougUV": "remus100",
    "SurfaceVessel": "otter",
}
SENSORS = {
    "IMUSensor": "imu",
    "DepthSensor": "depth",
    "DVLSensor": "dvl",
    "VelocitySensor": "velocity",
    "MagnetometerSensor": "compass",
}
"""The sensors of the replacement that stand for those of the agent."""
CAMERAS = ("RGBCamera", "CameraSensor")
SONARS = {
    "ImagingSonar": ("forward_looking", 120.0, 20.0, 0.1, 10.0, 512.0),
    "ProfilingSonar": ("forward_looking", 120.0, 1.0, 0.5, 75.0, 750.0),
    "SidescanSonar": ("side_scan", 170.0, 0.25, 0.5, 35.0, 690.0),
    "SinglebeamSonar": ("single_beam", 30.0, 0.0, 0.5, 10.0, 200.0),
}
"""Kinds of sonars, and HoloOcean's defaults: azimuth or opening, elevation [deg], ranges [m], bins of range."""
SOCKETS = {
    ("TorpedoAUV", "CameraSocket"): (0.0, 90.0, 0.0),
    ("TorpedoAUV", "SonarSocket"): (0.0, 90.0, 0.0),
    ("SurfaceVessel", "Payload"): (0.0, 90.0, 0.0),
}
"""Roll, pitch and yaw of the sockets that are turned [deg], by agent."""


def read_holoocean(path: Path, found: Found | None = None) -> Found:
    """Return the agents of a scenario as vehicles, in `found` if given. Raises ValueError or OSError."""
    values = read_json(path)
    if not isinstance(values, dict) or not isinstance(values.get("agents"), list):
        raise ValueError(f"'{path}': must be an object with a list of agents")
    found = found or Found("")
    found.name = plain_name(str(values.get("name") or path.stem))
    if "world" in values:
        found.left_out(f"world '{values['world']}' of package '{values.get('package_name')}'")
    for key in sorted(values.keys() - {"name", "world", "package_name", "agents", "main_agent", "ticks_per_sec"}):
        found.left_out(f"{key} = {_short(values[key])}")
    for k, agent in enumerate(values["agents"]):
        at = f"'{path}': agents/{k}"
        try:
            if not isinstance(agent, dict):
                raise ValueError(f"{at}: must be an object")
            found.robots.append(_robot(agent, at, found))
        except ValueError as error:
            found.refusals.append(error)
            found.left_out(str(error).removeprefix(f"'{path}': "))
    if not found.robots:
        raise found.refusals[0] if found.refusals else ValueError(f"'{path}': agents: must have at least one")
    return found


def _robot(agent: dict[str, Any], path: str, found: Found) -> Robot:
    kind = agent.get("agent_type")
    if not isinstance(kind, str) or kind not in AGENTS:
        raise ValueError(f"{path}/agent_type: {kind!r}: must be one of {', '.join(AGENTS)}")
    place = _pose(agent, path)
    place = Pose(ENU_FROM_NWU @ place.position_m, ENU_FROM_NWU @ place.turn)
    name = plain_name(str(agent.get("agent_name") or kind), [robot.name for robot in found.robots])
    robot = Robot(name, place, model=AGENTS[kind])
    found.assumed(f"agent '{name}': {kind} becomes the packaged vehicle '{AGENTS[kind]}' with its own sensors")
    for key in sorted(agent.keys() - {"agent_type", "agent_name", "location", "rotation", "sensors"}):
        found.left_out(f"agent '{name}': {key} = {_short(agent[key])}")
    for k, sensor in enumerate(_objects(agent.get("sensors", []), f"{path}/sensors")):
        try:
            _sensor(robot, kind, sensor, f"{path}/sensors/{k}", found)
        except ValueError as error:
            found.left_out(str(error))
    return robot


def _sensor(robot: Robot, agent: str, sensor: dict[str, Any], path: str, found: Found) -> None:
    """Add a camera or an imaging sonar to a vehicle, or note it. Raises ValueError."""
    kind = str(sensor.get("sensor_type"))
    what = f"agent '{robot.name}': sensor {kind}"
    given = sensor.get("configuration") or {}
    if not isinstance(given, dict):
        raise ValueError(f"{path}/configuration: must be an object")
    stated = {str(key).lower(): value for key, value in given.items()}  # Unreal's texts are alike in both cases
    used: set[str] = set()

    def number(key: str, default: float) -> float:
        used.add(key.lower())
        value = stated.get(key.lower(), default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0.0 or not np.isfinite(value):
            raise ValueError(f"{path}/configuration/{key}: {value!r}: must be a positive number")
        return float(value)

    def bins(key: str, extent: float, default: float) -> float:
        """Return the number of bins along an extent, by their number or their size."""
        return (
            round(extent / number(f"{key}Res", 1.0)) if f"{key}res".lower() in stated else number(f"{key}Bins", default)
        )

    if kind in CAMERAS or kind in SONARS:
        name = str(sensor.get("sensor_name") or kind)
        pose = _pose(sensor, path)
        if socket := str(sensor.get("socket") or ""):
            pose = Pose(np.zeros(3), turned(*np.radians(SOCKETS.get((agent, socket), (0.0, 0.0, 0.0))))).then(pose)
            found.assumed(f"{what}: '{socket}' is at the vehicle's origin: HoloOcean does not state its place")
    if kind in CAMERAS:
        size = int(number("CaptureWidth", 256)), int(number("CaptureHeight", 256))
        if max(size) > LARGEST_SIDE or (angle := number("FovAngle", 90.0)) >= 180.0:
            raise ValueError(f"{path}: must have at most {LARGEST_SIDE} pixels a side, and less than 180 degrees")
        put_camera(robot, name, pose, angle, size)
    elif kind in SONARS:
        mine, azimuth, elevation, near, far, count = SONARS[kind]
        far = number("RangeMax", far)
        values = {"range_max_m": far, "range_bins": bins("Range", far - number("RangeMin", near), count)}
        used.discard("rangemin")
        if mine == "single_beam":
            values["beam_width_deg"] = number("OpeningAngle", azimuth)
        else:
            azimuth, elevation = number("Azimuth", azimuth), number("Elevation", elevation)
        if mine == "side_scan":  # its azimuth is that of both sides, across the track
            values |= {
                "along_width_deg": elevation,
                "vertical_width_deg": azimuth / 2.0,
                "depression_deg": 90.0 - azimuth / 4.0,
            }
        elif mine == "forward_looking":
            values |= {
                "field_of_view_deg": azimuth,
                "vertical_width_deg": elevation,
                "beams": bins("Azimuth", azimuth, 512),
            }
        put_imaging(robot, found, what, name, mine, pose, values)
    elif kind not in SENSORS:
        found.left_out(what)
        return
    rest = {key: value for key, value in given.items() if str(key).lower() not in used}
    rest |= {key: sensor[key] for key in ("Hz", "tick_every") if key in sensor}
    if rest:
        found.left_out(f"{what}: {', '.join(f'{key} = {_short(value)}' for key, value in rest.items())}")


def _pose(item: dict[str, Any], path: str) -> Pose:
    at = np.array(_three(item.get("location", [0, 0, 0]), f"{path}/location", "m"))
    return Pose(at, turned(*np.radians(_three(item.get("rotation", [0, 0, 0]), f"{path}/rotation", "deg"))))


def _short(value: Any) -> str:
    return text if len(text := str(value)) <= 40 else f"{text[:37]}..."


def _three(value: Any, path: str, unit: str) -> list[float]:
    if (
        not isinstance(value, list)
        or len(value) != 3
        or not all(isinstance(each, int | float) and not isinstance(each, bool) and np.isfinite(each) for each in value)
    ):
        raise ValueError(f"{path}: {value!r}: must be three finite numbers [{unit}]")
    return [float(each) for each in value]


def _objects(value: Any, path: str) -> Iterator[dict[str, Any]]:
    if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
        raise ValueError(f"{path}: must be a list of objects")
    yield from value
