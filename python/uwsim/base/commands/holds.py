"""A vehicle's holds, such as the depth hold: the target, the axes and the instruments of each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HoldKind:
    """A kind of hold. keeps: the quantity that it holds.

    axes: the axes that it controls, all of which the vehicle needs. sensors: the kinds of sensor that measure the
    quantity; the vehicle needs one of them. patience_s: how long the sensor may be silent before the hold is lost.
    then: the hold that takes over after a loss, or "".
    """

    keeps: str
    axes: tuple[str, ...]
    sensors: tuple[str, ...]
    patience_s: float
    then: str = ""


HOLDS = {
    "heading": HoldKind("heading", ("yaw",), ("imu",), 1.0),
    "depth": HoldKind("depth", ("heave",), ("depth", "pressure"), 1.0),
    "altitude": HoldKind("height above the bed", ("heave",), ("altitude",), 1.0, then="depth"),
    "position": HoldKind("horizontal position", ("surge", "sway"), ("dvl",), 5.0),
    "speed": HoldKind("speed ahead over ground, without drift", ("surge", "sway"), ("dvl",), 5.0),
}
"""The holds by name. Every hold also needs the IMU, since it steers by the vehicle's estimate."""
EXCLUSIVE = (("depth", "altitude"), ("position", "speed"))
"""Pairs of holds that set the same axes."""
