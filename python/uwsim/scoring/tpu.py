"""Total propagated uncertainty (TPU) of soundings, from the uncertainties of the instruments that contribute to it.

Hare, R. (1995), Depth and position error budgets for multibeam echosounding, International Hydrographic Review 72(2),
37-69. Errors are small, independent and normally distributed. Each moves a sounding by its standard deviation times a
vector, and the covariance of the sounding is the sum of their outer products. The vectors are exact to first order for
any attitude and lever arm; for a level vehicle they are Hare's terms, with v from the vehicle's reference point and w
from the transducer to the sounding, c the speed of sound and theta the beam's angle from the vertical:

| term | vector | for a level vehicle |
|---|---|---|
| roll, pitch, heading | axis of rotation x v | vertical: y of v for roll, x for pitch |
| mount: of the head, about each axis | axis x w | as above, about the transducer |
| position, east and north each; depth, heave, tide | along that axis | |
| range, angle: of the sounder | along the ray; along the arc | vertical: cos(theta); y |
| lever: of the transducer, along each axis | along that axis | |
| latency | velocity over ground | horizontal, speed |
| sound speed of the profile | w / c, and along the arc tan(theta) / (2 c) | vertical: z / c and y tan(theta) / (2 c) |
| sound speed at a flat array | along the arc tan(steering) / c | vertical: y tan(steering) / c |

A ping in physics mode states the sounder's own errors, to which `range` and `angle` add. Beyond 85 degrees, the
terms of sound speed are those at 85 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.options import named_numbers

if TYPE_CHECKING:
    from uwsim.mapping.files.swath import Swath

STEEPEST = math.tan(math.radians(85.0))
LIMITS = {
    "roll": (0.0, 10.0, "deg"), "pitch": (0.0, 10.0, "deg"), "heading": (0.0, 45.0, "deg"), "mount": (0.0, 10.0, "deg"),
    "position": (0.0, 1000.0, "m"), "depth": (0.0, 100.0, "m"), "lever": (0.0, 10.0, "m"), "latency": (0.0, 10.0, "s"),
    "sound_speed": (0.0, 100.0, "m/s"), "surface_speed": (0.0, 100.0, "m/s"), "heave": (0.0, 10.0, "m"),
    "tide": (0.0, 10.0, "m"), "range": (0.0, 100.0, "m"), "angle": (0.0, 10.0, "deg"),
}  # fmt: skip


@dataclass(frozen=True)
class Uncertainties:
    """Standard deviations of a survey's instruments in the units of LIMITS; see the module."""

    roll: float = 0.0
    pitch: float = 0.0
    heading: float = 0.0
    mount: float = 0.0
    position: float = 0.0
    depth: float = 0.0
    lever: float = 0.0
    latency: float = 0.0
    sound_speed: float = 0.0
    surface_speed: float = 0.0
    heave: float = 0.0
    tide: float = 0.0
    range: float = 0.0
    angle: float = 0.0

    @classmethod
    def parse(cls, text: str) -> Uncertainties:
        """Return those in a text such as roll=0.05,position=0.5. Raises ValueError, which names the key."""
        return cls(**named_numbers("--uncertainty", text, LIMITS))

    def __str__(self) -> str:
        found = ((field.name, getattr(self, field.name), LIMITS[field.name][2]) for field in fields(self))
        return ", ".join(f"{name} {value:g} {unit}" for name, value, unit in found if value)


def deviations(swath: Swath, known: Uncertainties, pose: Floats | None = None) -> tuple[Floats, Floats]:
    """Return the vertical and horizontal standard deviation of each sounding, (n,), nan without detection.

    pose: covariance (6, 6) of the reference point's place [m] and of a rotation [rad], in the swath's level axes, from
    the vehicle's own estimate; it adds to `known`. A share of the sounder that is nan counts as none. The horizontal
    one is along the direction in which it is largest.
    """
    covariance = _covariance(swath, known, pose)
    east, north, across = covariance[:, 0, 0], covariance[:, 1, 1], covariance[:, 0, 1]
    largest = 0.5 * (east + north) + np.hypot(0.5 * (east - north), across)
    seen = swath.is_detected
    return np.where(seen, np.sqrt(covariance[:, 2, 2]), np.nan), np.where(seen, np.sqrt(largest), np.nan)


def _covariance(swath: Swath, known: Uncertainties, pose: Floats | None) -> Floats:
    """Return the covariance (n, 3, 3) of each sounding, forward, starboard and down."""
    seen = swath.is_detected
    v = np.where(seen[:, None], swath.sounding_m - [0.0, 0.0, swath.reference_depth_m], 0.0)
    moved = np.concatenate([_of_vehicle(swath, known, v), _of_sound(swath, known, v - swath.transducer_m)])
    covariance = np.einsum("kni,knj->nij", moved, moved)
    mount_rad, w = math.radians(known.mount), v - swath.transducer_m
    covariance += mount_rad**2 * ((w**2).sum(1)[:, None, None] * np.eye(3) - w[:, :, None] * w[:, None, :])
    vertical = known.depth**2 + known.heave**2 + known.tide**2
    covariance += np.diag([known.position**2, known.position**2, vertical]) + known.lever**2 * np.eye(3)
    if pose is not None:
        turned = np.zeros((len(v), 3, 6))
        turned[:, :, :3] = np.eye(3)
        turned[:, :, 3:] = np.stack([np.cross(axis, v) for axis in np.eye(3)], axis=2)
        covariance += turned @ pose @ turned.transpose(0, 2, 1)
    return np.asarray(covariance, np.float64)


def _of_vehicle(swath: Swath, known: Uncertainties, v: Floats) -> Floats:
    """Return how far attitude and latency move each sounding, (terms, n, 3)."""
    pitch = swath.pitch_rad
    axes = np.array([[math.cos(pitch), 0.0, -math.sin(pitch)], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    turns = [np.cross(axis, v) for axis in axes]  # roll is about the pitched bow, pitch about the level starboard
    ahead_rad = swath.course_rad - swath.heading_rad
    velocity = swath.speed_m_s * np.array([math.cos(ahead_rad), math.sin(ahead_rad), 0.0])
    sizes = [*np.radians([known.roll, known.pitch, known.heading]), known.latency]
    return np.stack([size * each for size, each in zip(sizes, [*turns, np.tile(velocity, (len(v), 1))], strict=True)])


def _of_sound(swath: Swath, known: Uncertainties, w: Floats) -> Floats:
    """Return how far the sounder itself and the speed of sound move each sounding, (terms, n, 3)."""
    across_m, down_m = np.hypot(w[:, 0], w[:, 1]), w[:, 2]
    level = np.where(across_m[:, None] > 1e-9, w[:, :2] / np.maximum(across_m, 1e-9)[:, None], [0.0, 1.0])
    outward = np.column_stack([level, np.zeros(len(w))])
    arc = outward * down_m[:, None] - np.array([0.0, 0.0, 1.0]) * across_m[:, None]  # to a larger angle, per rad
    steep = np.minimum(across_m / np.maximum(np.abs(down_m), 1e-9), STEEPEST)
    steering = np.minimum(np.abs(np.tan(np.where(np.isfinite(swath.beam_rad), swath.beam_rad, 0.0))), STEEPEST)
    profile, surface = known.sound_speed / swath.sound_speed_m_s, known.surface_speed / swath.sound_speed_m_s
    own_vertical, own_horizontal = (
        np.where(np.isfinite(each), each, 0.0)[:, None]
        for each in (swath.vertical_deviation_m, swath.horizontal_deviation_m)
    )
    return np.stack([
        own_vertical * [0.0, 0.0, 1.0], own_horizontal * outward, profile * w, 0.5 * profile * steep[:, None] * arc,
        surface * steering[:, None] * arc, known.range * w / np.maximum(np.linalg.norm(w, axis=1), 1e-9)[:, None],
        math.radians(known.angle) * arc,
    ])  # fmt: skip
