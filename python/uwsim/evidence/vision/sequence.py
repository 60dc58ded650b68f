"""Stereo pictures along a straight leg over the bed, with their true poses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
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
ORBIT_M, ORBIT_HEIGHT_M, ORBIT_SIZE, ORBIT_S = 4.0, 2.5, (640, 480), 0.5
"""An orbit's radius, its height above the highest bed under it, its pictures' size, and the time between them."""


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
    for start, heading in _draws(sim, seed, 7151):
        along = start + np.linspace(0, length_m, 25)[:, None] * [np.cos(heading), np.sin(heading)]
        places = _clear(sim, along, along, HEIGHT_M)
        if places is not None:
            return places[0], heading
    raise ValueError(
        f"scenario = {sim.scenario.name!r}: has no straight leg of {length_m:g} m, {HEIGHT_M:g} m above its bed"
    )


def _set_shutter(camera: Camera) -> None:
    """Set the shutter time of an automatic exposure: as short as the light that the camera sees now allows."""
    full_sun, here = camera.capture(without=("exposure",)).gain, camera.capture().gain
    shutter_ms = LONGEST_SHUTTER_MS * min(1.0, here / (DIMMEST * full_sun))
    camera.change(camera.mount.model_copy(update={"shutter_ms": shutter_ms}))


def _draws(sim: Simulator, seed: int, stream: int) -> Iterator[tuple[Floats, float]]:
    """Yield places (2,) in the middle of the terrain, and headings [rad]."""
    random = np.random.default_rng([seed, stream])
    x0, y0, x1, y1 = sim.world.terrain_extent_m
    for _ in range(TRIES):
        place = random.uniform((0.7 * x0, 0.7 * y0), (0.7 * x1, 0.7 * y1))
        yield place, float(random.uniform(0, 2 * np.pi))


def _clear(sim: Simulator, along: Floats, bed: Floats, height_m: float) -> Floats | None:
    """Return the places (n, 3) of `along` above the highest of `bed`, or None where solids or the surface are near."""
    z = float(np.max(sim.world.height_at(bed))) + height_m
    places = np.column_stack([along, np.full(len(along), z)])
    free = z < -1.5 and all(sim.world.solid_around(tuple(place)) is None for place in places)
    return places if free else None


@contextmanager
def _in(scenario: str, condition: Condition, seed: int) -> Iterator[tuple[Simulator, Camera]]:
    """Yield a simulator in a condition, its vehicle released, and the front camera. Raises ValueError."""
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
        yield sim, rov.cameras["front"]


def orbit(
    scenario: str, condition: Condition, seed: int, pictures: int, without: Sequence[str] = ()
) -> Iterator[Frame]:
    """Yield the pictures of a circle around a place on the bed, all towards it. Raises ValueError as `shots` does."""
    with _in(scenario, condition, seed) as (sim, front):
        camera = front.resized(*ORBIT_SIZE)
        turns = 2 * np.pi * np.arange(pictures) / pictures
        circle = ORBIT_M * np.column_stack([np.cos(turns), np.sin(turns)])
        for middle, _ in _draws(sim, seed, 7152):
            places = _clear(sim, middle + circle, np.vstack([middle + circle, middle]), ORBIT_HEIGHT_M)
            if places is not None:
                break
        else:
            raise ValueError(f"scenario = {scenario!r}: has no clear circle of {ORBIT_M:g} m above its bed")
        pitch = float(np.arctan2(ORBIT_HEIGHT_M, ORBIT_M))
        for place, turn in zip(places, turns, strict=True):
            sim.rov.place(place, Rotation.from_euler("ZYX", [turn + np.pi, pitch, 0.0]).as_quat())
            yield camera.capture(without=(*condition.without, *without))
            sim.advance(ORBIT_S)


def shots(scenario: str, condition: Condition, seed: int, frames: int, without: Sequence[str] = ()) -> Iterator[Shot]:
    """Yield the pictures of a leg in a condition. without: effects that are switched off besides. Raises ValueError."""
    with _in(scenario, condition, seed) as (sim, front):
        rov, camera = sim.rov, front.resized(*SIZE)
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
