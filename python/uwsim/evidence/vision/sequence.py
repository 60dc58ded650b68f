"""Stereo pictures along a straight leg over the bed, with their true poses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.instruments.cameras import Camera, Frame
from uwsim.simulator.simulator import Simulator

Floats = NDArray[np.float64]
SIZE = (320, 240)
BASELINE_M, HEIGHT_M, PITCH_DEG = 0.12, 2.0, 45.0
RATE_HZ, SPEED_M_S = 5.0, 0.5
LONGEST_SHUTTER_MS, DIMMEST = 33.0, 30.0
"""The longest shutter time, and the factor on the full sun's exposure with which a camera reaches it."""
LAMP_SUN_DEG = -6.0
"""Below this elevation of the sun the lamps are on."""
TRIES = 500


@dataclass(frozen=True)
class Condition:
    """Water and light. jerlov: the water type, or None for the scenario's. without: effects that are absent."""

    name: str
    jerlov: str | None = None
    sun_deg: float | None = None
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class Shot:
    """The left and the right picture of one time, 5 ms apart, as of two cameras triggered in turn."""

    left: Frame
    right: Frame


def leg(sim: Simulator, seed: int, length_m: float) -> tuple[Floats, float]:
    """Return the start (3,) and heading [rad] of a leg that keeps HEIGHT_M above the bed and clear of solids.

    Raises ValueError if none is found.
    """
    random = np.random.default_rng([seed, 7151])
    x0, y0, x1, y1 = sim.world.terrain_extent_m
    for _ in range(TRIES):
        x, y = random.uniform((0.7 * x0, 0.7 * y0), (0.7 * x1, 0.7 * y1))
        heading = float(random.uniform(0, 2 * np.pi))
        along = np.array([x, y]) + np.linspace(0, length_m, 25)[:, None] * [np.cos(heading), np.sin(heading)]
        z = float(np.max(sim.world.height_at(along))) + HEIGHT_M
        places = [(east, north, z) for east, north in along]
        if z < -1.5 and all(sim.world.solid_around(place) is None for place in places):
            return np.array(places[0]), heading
    raise ValueError(
        f"scenario = {sim.scenario.name!r}: has no straight leg of {length_m:g} m, {HEIGHT_M:g} m above its bed"
    )


def _set_shutter(camera: Camera) -> None:
    """Set the shutter time of an automatic exposure: as short as the light that the camera sees now allows."""
    full_sun, here = camera.capture(without=("exposure",)).gain, camera.capture().gain
    shutter_ms = LONGEST_SHUTTER_MS * min(1.0, here / (DIMMEST * full_sun))
    camera.change(camera.mount.model_copy(update={"shutter_ms": shutter_ms}))


def shots(scenario: str, condition: Condition, seed: int, frames: int, without: Sequence[str] = ()) -> Iterator[Shot]:
    """Yield the pictures of a leg in a condition. without: effects that are switched off besides. Raises ValueError."""
    with Simulator(scenario, seed=seed) as sim:
        rov = sim.rov
        rov.release()
        if condition.jerlov is not None:
            sim.set_optics(jerlov=condition.jerlov)
        if condition.sun_deg is not None:
            sim.set_optics(sun_elevation_deg=condition.sun_deg)
        for lamp in rov.lamps.values():
            lamp.on = condition.sun_deg is not None and condition.sun_deg <= LAMP_SUN_DEG
        if "front" not in rov.cameras:
            raise ValueError(f"scenario = {scenario!r}: its first vehicle has no camera 'front'")
        camera = rov.cameras["front"].resized(*SIZE)
        start, heading = leg(sim, seed, frames * SPEED_M_S / RATE_HZ)
        turn = Rotation.from_euler("ZYX", [heading, np.radians(PITCH_DEG), 0.0])
        ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
        starboard = turn.apply([0.0, -BASELINE_M, 0.0])
        velocity = (*turn.inv().apply(SPEED_M_S * ahead), 0.0, 0.0, 0.0)
        off = (*condition.without, *without)
        rov.place(start, turn.as_quat(), velocity)
        _set_shutter(camera)
        for k in range(frames):
            at = start + k * SPEED_M_S / RATE_HZ * ahead
            rov.place(at, turn.as_quat(), velocity)
            left = camera.capture(without=off)
            sim.advance(sim.scenario.step_s)
            rov.place(at + starboard, turn.as_quat(), velocity)
            yield Shot(left, camera.capture(without=off))
            sim.advance(1 / RATE_HZ - sim.scenario.step_s)
