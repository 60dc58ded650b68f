"""The publications of a vehicle in IMC: its true motion for DUNE's simulated instruments, or its own instruments.

IMC's frames: north, east, down; body x forward, y to starboard, z down. Angles in rad, latitudes and longitudes on WGS
84 in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.quaternions import matrix
from uwsim.bridges.imc.wire import Sent
from uwsim.mapping.files.georeference import RADIUS_M, SQUARED_ECCENTRICITY, Georeference
from uwsim.scenario import VehicleModel
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

Array = NDArray[np.float64]
Named = tuple[str, dict[str, Any]]

FLIP = np.diag([1.0, -1.0, -1.0])
"""Body axes of uwsim to IMC's and back."""
NED_FROM_WORLD = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
SURFACE_M = 0.3
"""A shallower vehicle has its antenna in the air; DUNE's "Underwater Depth Threshold"."""
NAVIGATION = "navigation"
"""The label of the entity of the vehicle's estimate."""
UNKNOWN_ALTITUDE_M = -1.0
ALL_AXES, POSITION_AND_TIME, COURSE, SPEED, ACCURACY = 7, 0x0007, 0x0008, 0x0010, 0x0020
SIMULATED_FIX, MULTIBEAM = 4, 2


class Place(NamedTuple):
    """The reference of positions: the world's origin [rad, WGS 84], and the world's place on Earth."""

    latitude_rad: float
    longitude_rad: float
    world: Georeference

    @classmethod
    def of(cls, world: Georeference) -> Place:
        """Return the place of a world's origin. Raises ValueError for a world without a place on Earth."""
        if world.crs is None:
            raise ValueError("imc: the scenario has no place on Earth, which every IMC position has: give it earth")
        latitude_rad, longitude_rad = np.radians(world.degrees(np.zeros(3))).tolist()
        return cls(latitude_rad, longitude_rad, world)

    def offset_m(self, position_world_m: Array) -> tuple[float, float]:
        """Return how far north and east of the reference a position is, in the plane that touches WGS 84 there.

        DUNE's WGS84::displacement does the same.
        """
        latitude, longitude = np.radians(self.world.degrees(position_world_m)).tolist()
        x, y, z = _geocentric_m(latitude, longitude) - _geocentric_m(self.latitude_rad, self.longitude_rad)
        sine, cosine = math.sin(self.latitude_rad), math.cos(self.latitude_rad)
        outward = math.cos(self.longitude_rad) * x + math.sin(self.longitude_rad) * y
        east = -math.sin(self.longitude_rad) * x + math.cos(self.longitude_rad) * y
        return float(-sine * outward + cosine * z), float(east)


def _geocentric_m(latitude_rad: float, longitude_rad: float) -> Array:
    sine, cosine = math.sin(latitude_rad), math.cos(latitude_rad)
    radius_m = RADIUS_M / math.sqrt(1.0 - SQUARED_ECCENTRICITY * sine * sine)
    across_m = radius_m * cosine
    return np.array([
        across_m * math.cos(longitude_rad), across_m * math.sin(longitude_rad),
        radius_m * (1.0 - SQUARED_ECCENTRICITY) * sine,
    ])  # fmt: skip


def _ned_from_world(place: Place, position_m: Array) -> Array:
    """Return the rotation from the world's axes at a position to true north, east and down."""
    north_rad = place.world.north_rad(position_m)
    sine, cosine = math.sin(north_rad), math.cos(north_rad)
    turned: Array = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]) @ NED_FROM_WORLD
    return turned


def angles_rad(ned_from_body: Array) -> tuple[float, float, float]:
    """Return roll, pitch and heading of a rotation from IMC's body axes to north, east and down."""
    return (
        math.atan2(ned_from_body[2, 1], ned_from_body[2, 2]),
        -math.asin(max(-1.0, min(1.0, float(ned_from_body[2, 0])))),
        math.atan2(ned_from_body[1, 0], ned_from_body[0, 0]),
    )


class _Motion(NamedTuple):
    """A position [m], attitude and velocities in IMC's axes; `water` is the body's velocity through the water."""

    position_m: Array
    ned_from_world: Array
    ned_from_body: Array
    velocity_m_s: Array
    rate_rad_s: Array

    @classmethod
    def of(cls, known: Any, place: Place) -> _Motion:
        position_m = np.asarray(known.pose.position_world_m)
        ned_from_world = _ned_from_world(place, position_m)
        ned_from_body = ned_from_world @ known.pose.world_from_body[:3, :3] @ FLIP
        velocity = known.velocity
        linear, angular = np.asarray(velocity.linear_body_m_s), np.asarray(velocity.angular_body_rad_s)
        return cls(position_m, ned_from_world, ned_from_body, FLIP @ linear, FLIP @ angular)

    def fields(self, place: Place, velocity_m_s: Array) -> dict[str, float]:
        north_m, east_m = place.offset_m(self.position_m)
        names = ("phi", "theta", "psi", "u", "v", "w", "p", "q", "r")
        values = (*angles_rad(self.ned_from_body), *velocity_m_s.tolist(), *self.rate_rad_s.tolist())
        return {
            "lat": place.latitude_rad, "lon": place.longitude_rad, "x": north_m, "y": east_m,
            "z": float(-self.position_m[2]), **dict(zip(names, values, strict=True)),
        }  # fmt: skip


def simulated_state(sim: Simulator, vehicle: Vehicle, place: Place) -> Named:
    """Return the true motion, its velocity through the water as DUNE's simulators expect, and the water's own."""
    motion = _Motion.of(vehicle, place)
    water: Array = np.asarray(sim.world.water.velocity_m_s(motion.position_m[None], sim.time_s), np.float64)[0]
    stream_m_s = motion.ned_from_world @ water
    found = motion.fields(place, motion.velocity_m_s - motion.ned_from_body.T @ stream_m_s)
    return "SimulatedState", {**found, **dict(zip(("svx", "svy", "svz"), stream_m_s.tolist(), strict=True))}


def estimated_state(vehicle: Vehicle, place: Place) -> Named:
    """Return the vehicle's own estimate of its motion over ground."""
    motion = _Motion.of(vehicle.navigation.shown, place)
    north, east, down = (motion.ned_from_body @ motion.velocity_m_s).tolist()
    return "EstimatedState", {
        **motion.fields(place, motion.velocity_m_s), "vx": north, "vy": east, "vz": down,
        "depth": vehicle.estimate.depth_m, "alt": _altitude_m(vehicle),
    }  # fmt: skip


def _altitude_m(vehicle: Vehicle) -> float:
    for sensor in vehicle.sensors.values():
        if sensor.kind == "altitude" and sensor.on:
            sample: Any = sensor.sample()
            if sample.valid and math.isfinite(sample.value):
                return float(sample.value)
    return UNKNOWN_ALTITUDE_M


class Instruments:
    """A vehicle's instruments, each of whose measurements is published once, under its own name as a label."""

    def __init__(
        self, vehicle: Vehicle, place: Place, fins: Mapping[str, Servo], clock: Callable[[float], float]
    ) -> None:
        self._vehicle, self._place, self._servos, self._clock = vehicle, place, fins, clock
        self._seen_ns: dict[str, int] = {}
        self._fixed_s = -math.inf

    def read(self, time_s: float) -> Iterator[Sent]:
        """Yield what was measured since the last call. Must be called on the simulator's thread."""
        yield NAVIGATION, *estimated_state(self._vehicle, self._place)
        if time_s - self._fixed_s >= 1.0 and self._has_fix():
            self._fixed_s = time_s
            yield "gps", "GpsFix", self._fix(time_s)
        ned_from_world = _ned_from_world(self._place, np.asarray(self._vehicle.navigation.shown.pose.position_world_m))
        for label, sensor in self._vehicle.sensors.items():
            if not sensor.on or sensor.kind not in _MESSAGES:
                continue
            sample: Any = sensor.sample()
            if self._seen_ns.get(label) == sample.stamp_ns:
                continue
            self._seen_ns[label] = sample.stamp_ns
            for name, content in _MESSAGES[sensor.kind](sample, ned_from_world):
                yield label, name, content
        for name, angle_rad in self._vehicle.fins.items():
            if (servo := self._servos.get(name)) is not None:
                yield "servos", "ServoPosition", {"id": servo.number, "value": servo.sign * angle_rad}

    def _has_fix(self) -> bool:
        """Return whether the vehicle's GPS has a fix; without a GPS, whether the vehicle is at the surface."""
        receivers = [each for each in self._vehicle.sensors.values() if each.kind == "gps" and each.on]
        if receivers:
            return receivers[0].sample().valid
        return bool(self._vehicle.pose.position_world_m[2] > -SURFACE_M)

    def _fix(self, time_s: float) -> dict[str, Any]:
        """Return the estimate as a fix; no receiver has errors of its own here."""
        estimate = self._vehicle.navigation.shown
        latitude_deg, longitude_deg = self._place.world.degrees(np.asarray(estimate.pose.position_world_m)).tolist()
        motion = _Motion.of(estimate, self._place)
        north, east, _ = motion.ned_from_body @ motion.velocity_m_s
        now = datetime.fromtimestamp(self._clock(time_s), UTC)
        day_s = 3600 * now.hour + 60 * now.minute + now.second + 1e-6 * now.microsecond
        return {
            "validity": POSITION_AND_TIME | COURSE | SPEED | ACCURACY, "type": SIMULATED_FIX, "utc_year": now.year,
            "utc_month": now.month, "utc_day": now.day, "utc_time": day_s, "lat": math.radians(latitude_deg),
            "lon": math.radians(longitude_deg), "satellites": 8, "cog": math.atan2(east, north),
            "sog": math.hypot(east, north), "hdop": 1.0, "vdop": 1.0,
            "hacc": float(np.linalg.norm(estimate.position_std_m[:2])), "vacc": float(estimate.position_std_m[2]),
        }  # fmt: skip


def _three(values: Any, **more: Any) -> dict[str, Any]:
    x, y, z = (FLIP @ np.asarray(values, np.float64)).tolist()
    return {**more, "x": x, "y": y, "z": z}


def _imu(sample: Any, ned_from_world: Array) -> Iterator[Named]:
    value = sample.value
    if sample.valid:
        yield "AngularVelocity", _three(value.angular_velocity_rad_s, time=sample.stamp_s)
        yield "Acceleration", _three(value.linear_acceleration_m_s2, time=sample.stamp_s)
        world_from_body = matrix(value.orientation_xyzw)
        phi, theta, psi = angles_rad(ned_from_world @ world_from_body @ FLIP)
        yield "EulerAngles", {"time": sample.stamp_s, "phi": phi, "theta": theta, "psi": psi, "psi_magnetic": psi}


def _dvl(sample: Any, _: Array) -> Iterator[Named]:
    has_lock = bool(sample.valid and sample.value.bottom_lock)
    velocity = sample.value.velocity_m_s if has_lock else (0.0, 0.0, 0.0)
    yield "GroundVelocity", _three(velocity, validity=ALL_AXES if has_lock else 0)


def _altitude(sample: Any, _: Array) -> Iterator[Named]:
    is_valid = bool(sample.valid and math.isfinite(sample.value))
    yield "Distance", {"validity": int(is_valid), "value": float(sample.value) if is_valid else 0.0}


def _single(name: str, factor: float = 1.0) -> Callable[[Any, Array], Iterator[Named]]:
    def messages(sample: Any, _: Array) -> Iterator[Named]:
        if sample.valid and math.isfinite(sample.value):
            yield name, {"value": factor * float(sample.value)}

    return messages


_MESSAGES: dict[str, Callable[[Any, Array], Iterator[Named]]] = {
    "imu": _imu, "dvl": _dvl, "altitude": _altitude, "depth": _single("Depth"),
    "pressure": _single("Pressure", 0.01), "temperature": _single("Temperature"),
}  # fmt: skip


class Servo(NamedTuple):
    """A fin's servo. number: DUNE's. sign: of the fin's angle over the servo's. travel_rad: to both sides [rad]."""

    number: int
    sign: float
    travel_rad: float


def servos(model: VehicleModel) -> dict[str, Servo]:
    """Return the servos of a model's fins by name, numbered as DUNE's LAUV has them: bottom, port, starboard, top.

    A positive angle of 0 and 3 pushes the stern to starboard, one of 1 and 2 pushes it up. A fin with another direction
    than these has none.
    """
    found: dict[str, Servo] = {}
    for name, fin in model.fins.items():
        span = np.asarray(fin.span, np.float64) / np.linalg.norm(fin.span)
        if fin.deflection_max_deg == 0.0 or max(abs(span[1]), abs(span[2])) < 0.9:
            continue
        push = -np.cross((1.0, 0.0, 0.0), span)  # the force of a positive angle
        is_rudder = abs(span[2]) > abs(span[1])
        wanted = np.array([0.0, -1.0, 0.0]) if is_rudder else np.array([0.0, 0.0, 1.0])
        number = (3 if span[2] > 0 else 0) if is_rudder else (1 if span[1] > 0 else 2)
        found[name] = Servo(number, float(np.sign(push @ wanted)), math.radians(fin.deflection_max_deg))
    return found
