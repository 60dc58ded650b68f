"""Acoustic devices of Stonefish: USBL between a robot and what is fixed, and beacons.

Source: Stonefish 1.6, ScenarioParser::ParseComm, USBLSimple and AcousticModem. A device states its number and that of
the one to which it is connected; the range between the two is the same from either end, and the bearing opposite.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uwsim.exchange.robots.robot import SENSES, Description, Robot, plain_name
from uwsim.exchange.robots.sensors import put_sensor
from uwsim.exchange.robots.xml_file import Element, Floats, Pose

USBL, MODEM = ("usbl", "usbl2"), "acoustic_modem"
PING_HZ, TONE_HZ, RANGE_MAX_M = 1.0, 25_000.0, (1.0, 10_000.0)
"""Assumed: the rate of a USBL that states none, and the tone of a beacon."""


class Fixed(NamedTuple):
    """A device that does not move. position_m: in the world."""

    element: Element
    position_m: Floats
    connected: str | None


def fixed_device(element: Element, position_m: Floats, found: Description) -> Fixed:
    """Return a device of the world or of a static body; a modem is a pinger, if it is under water."""
    kind = element.needed("type")
    to = element.find("connect")
    if kind == MODEM and position_m[2] < 0.0:
        name = plain_name(element.name, [each["name"] for each in found.pingers])
        found.pingers.append({"name": name, "position_m": position_m.tolist(), "frequency_hz": TONE_HZ})
        found.assumed(f"{element.path}: a pinger of {TONE_HZ:g} Hz, once in 2 s: Stonefish's has no tone", SENSES)
    elif kind not in (*USBL, MODEM):
        found.dropped(element, f", of type {kind}")
    return Fixed(element, position_m, None if to is None else to.attribute("device_id"))


def put_comm(robot: Robot, comm: Element, at: Pose, devices: list[Fixed], found: Description) -> None:
    """Add the USBL by which a robot and a fixed device range each other, or note the device.

    at: its pose on the robot. Here, the station is at the fixed end, and the sensor is the robot's.
    """
    kind, number, to = comm.needed("type"), comm.attribute("device_id"), comm.find("connect")
    connected = None if to is None else to.attribute("device_id")
    ends = {each.element.attribute("device_id"): each for each in devices}
    if kind in USBL:
        usbl, other = comm, ends.get(connected)
    else:
        other = next((e for e in devices if e.element.attribute("type") in USBL and e.connected == number), None)
        if kind != MODEM or other is None:
            hint = ": `--link ideal_acoustic` has its delays" if kind == MODEM else ""
            found.dropped(comm, f", of type {kind}{hint}")
            return
        usbl = other.element
    if other is None:
        found.assumed(f"{comm.path}: from the station, since device {connected} is not a fixed one", SENSES)
    else:
        found.station = [float(other.position_m[0]), float(other.position_m[1]), 0.0]
        found.assumed(f"{comm.path}: from the station, which is above {other.element.path}", SENSES)
    noise, steps = usbl.find("noise"), usbl.find("resolution")
    errors: dict[str, dict[str, float]] = {}
    for channel, keys, of, unit in (
        ("range", ("range",), "range", 1.0),
        ("bearing", ("horizontal_angle", "vertical_angle"), "angle", np.pi / 180.0),
    ):
        std = 0.0 if noise is None else max(noise.number(None, 0.0, key) for key in keys)
        step = 0.0 if steps is None else steps.number(None, 0.0, of)
        stated = {"std": std * unit, "quantum": step * unit}
        if any(stated.values()):
            errors[channel] = {key: float(value) for key, value in stated.items() if value > 0.0}
    more: dict[str, Any] = {"channels": errors} if errors else {}
    reach = usbl.numbers("specs", 1, "range")
    if reach is not None:
        more["range_max_m"] = float(np.clip(reach[0], *RANGE_MAX_M))
    rate = usbl.number("autoping", PING_HZ, "rate")
    put_sensor(robot, found, comm.path, comm.name, "usbl", Pose(at.position_m, np.eye(3)), rate, more)
