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
from uwsim.evidence.robots.xml_file import Pose, turned

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
        found.left_out(f"'{key}'")
    for k, agent in enumerate(values["agents"]):
        if not isinstance(agent, dict):
            raise ValueError(f"'{path}': agents/{k}: must be an object")
        found.robots.append(_robot(agent, f"'{path}': agents/{k}", found))
    return found


def _robot(agent: dict[str, Any], path: str, found: Found) -> Robot:
    kind = agent.get("agent_type")
    if not isinstance(kind, str) or kind not in AGENTS:
        raise ValueError(f"{path}/agent_type: {kind!r}: must be one of {', '.join(AGENTS)}")
    at = np.array(_three(agent.get("location", [0, 0, 0]), f"{path}/location", "m"))
    roll, pitch, yaw = np.radians(_three(agent.get("rotation", [0, 0, 0]), f"{path}/rotation", "deg"))
    others = [robot.name for robot in found.robots]
    name = plain_name(str(agent.get("agent_name") or kind), others)
    place = Pose(ENU_FROM_NWU @ at, ENU_FROM_NWU @ turned(roll, pitch, yaw))
    found.assumed(f"agent '{name}': {kind} becomes the packaged vehicle '{AGENTS[kind]}' with its own sensors")
    for key in sorted(agent.keys() - {"agent_type", "agent_name", "location", "rotation", "sensors"}):
        found.left_out(f"agent '{name}': '{key}'")
    for sensor in _objects(agent.get("sensors", []), f"{path}/sensors"):
        if (type_of := str(sensor.get("sensor_type"))) not in SENSORS:
            found.left_out(f"agent '{name}': sensor {type_of}")
    return Robot(name, place, model=AGENTS[kind])


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
