"""Compares the navigator with an extended Kalman filter from filterpy on the same samples of the same flights.

The peer has the state and the motion model that are common in ROS (Moore and Stouch 2014, "A Generalized Extended
Kalman Filter Implementation for the Robot Operating System"; robot_localization): position, roll, pitch and yaw,
velocities and rates in body axes, and accelerations, which stay constant but for process noise. It estimates no biases,
so the variances of its measurements include those of the biases. PROCESS_NOISE is robot_localization's default. With
it, position and attitude are disturbed directly; without those two ("motion only"), they follow from the velocities and
rates. All filters receive the same fixes, which dominate the position errors, so the errors are similar.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, at_most, within
from uwsim.evidence.validate.navigator.consistency import (
    LARGEST_EFFORTS,
    POSITION_STD_M,
    VELOCITY_STD_M_S,
    errors,
    nees_of,
    start_navigation,
)
from uwsim.evidence.validate.peers import group
from uwsim.instruments.sample_stream import SampleStream
from uwsim.navigation.estimation import Navigator
from uwsim.navigation.estimation.aids import north_rad
from uwsim.navigation.estimation.errors import whole_std
from uwsim.simulator.simulator import Simulator

FLIGHTS, LEGS, LEG_S, WARM_UP_LEGS = 6, 12, 5.0, 4
EVERY_IMU_SAMPLE = 8  # samples arrive at 200 Hz; robot_localization runs at 30 Hz by default
POSITION, ANGLES, VELOCITY, RATES, FORCES = (slice(k, k + 3) for k in range(0, 15, 3))
PROCESS_NOISE = np.array([0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015])
"""Variance per second of each state, in its squared unit (params/ekf.yaml of robot_localization)."""
MOTION_ONLY = PROCESS_NOISE * np.repeat((0.0, 0.0, 1.0, 1.0, 1.0), 3)
Measure = Callable[[Floats], Floats]
Sample = tuple[int, str, Floats]
"""Stamp [ns], sensor and reading."""


def checks() -> list[Check]:
    """Return the checks: position errors, the distance between both estimates, and the NEES of both."""
    sim, name = Simulator("lake"), group("navigation")
    looks = np.array([look for seed in range(FLIGHTS) for look in flight(sim, seed)])
    ours, default, motion = (looks[:, k] for k in range(3))  # each (looks, 3): error [m], distance to ours [m], NEES
    rms = {key: float(np.sqrt(np.mean(part[:, 0] ** 2))) for key, part in (("d", default), ("m", motion), ("u", ours))}
    apart = np.sqrt(np.mean(motion[:, 1] ** 2))
    high = chi2.ppf(0.999, 3 * FLIGHTS) / FLIGHTS  # errors within one flight are correlated
    return [
        at_most(name, "the navigator's rms position error, at the EKF's with default noise,", rms["d"], rms["u"], "m"),
        at_most(name, "the same, at 1.25 times the EKF's with motion only,", 1.25 * rms["m"], rms["u"], "m"),
        at_most(name, "rms distance of both positions, at the two errors together,", rms["m"] + rms["u"], apart, "m"),
        within(name, "the navigator's NEES of position", 3.0, float(ours[:, 2].mean()), 3.0, high / 3.0 - 1.0),
        at_most(name, "NEES of position of the EKF with default noise,", high, float(default[:, 2].mean())),
        at_most(name, "NEES of position of the EKF with motion only,", 3.0 * high, float(motion[:, 2].mean())),
    ]


def flight(sim: Simulator, seed: int) -> list[list[list[float]]]:
    """Fly with random efforts; return error [m], distance to the navigator [m] and NEES of position of each filter.

    In order: the navigator, the EKF with PROCESS_NOISE, the EKF with MOTION_ONLY.
    """
    navigator, draws = start_navigation(sim, seed)
    filters = [StandardFilter(sim, navigator, noise) for noise in (PROCESS_NOISE, MOTION_ONLY)]
    streams = opened(sim)
    looks = []
    for leg in range(LEGS):
        sim.rov.set_effort(*(LARGEST_EFFORTS * draws.uniform(-1.0, 1.0, 6)))
        sim.advance(LEG_S)
        rows = samples_of(streams)
        for peer in filters:
            peer.follow(rows, sim.time_s)
        if leg >= WARM_UP_LEGS:
            true_m, own_m = sim.rov.pose.position_world_m, navigator.pose.position_world_m
            error, covariance = errors(sim, navigator), navigator.covariance
            look = [[float(np.linalg.norm(error[:3])), 0.0, nees_of(error, covariance, slice(0, 3))]]
            for peer in filters:
                off = true_m - peer.x[POSITION]
                apart = float(np.linalg.norm(own_m - peer.x[POSITION]))
                look.append([float(np.linalg.norm(off)), apart, nees_of(off, peer.P, POSITION)])
            looks.append(look)
    return looks


class Beside:
    """The EKF with PROCESS_NOISE beside a navigator that has just started, on the same samples."""

    def __init__(self, sim: Simulator, navigator: Navigator) -> None:
        self._sim, self._filter, self._streams = sim, StandardFilter(sim, navigator, PROCESS_NOISE), opened(sim)

    def __call__(self) -> Floats:
        """Return the error of its position (3,) [m], now."""
        self._filter.follow(samples_of(self._streams), self._sim.time_s)
        return np.asarray(self._sim.rov.pose.position_world_m - self._filter.x[POSITION])


def opened(sim: Simulator) -> dict[str, SampleStream]:
    """Return streams of the samples that the filters receive, by sensor."""
    return {kind: sim.rov.sensors[kind].stream() for kind in ("imu", "dvl", "depth", "usbl", "compass")}


def samples_of(streams: Mapping[str, SampleStream]) -> list[Sample]:
    """Return the new valid samples by time; of the IMU, every EVERY_IMU_SAMPLE."""
    rows = [
        (int(stamp), kind, reading)
        for kind, samples in ((kind, stream.take()) for kind, stream in streams.items())
        for k, (stamp, reading, valid) in enumerate(
            zip(samples.stamps_ns, samples.readings, samples.valid, strict=True)
        )
        if valid and (kind != "imu" or k % EVERY_IMU_SAMPLE == 0)
    ]
    return sorted(rows, key=lambda row: row[:2])


class StandardFilter(ExtendedKalmanFilter):  # type: ignore[misc]  # filterpy has no types
    """filterpy's filter with 15 states: position, roll pitch yaw, velocity, rates, acceleration (body axes)."""

    def __init__(self, sim: Simulator, navigator: Navigator, process_noise: Floats):
        """Start at the pose of a navigator that has just started. process_noise (15,): variances per second."""
        super().__init__(15, 3)
        self._sensors = sim.rov.sensors
        self._gravity_m_s2, self._noise, self._time_s = sim.world.water.gravity_m_s2, process_noise, sim.time_s
        self.x = np.zeros(15)
        self.x[POSITION] = navigator.pose.position_world_m
        self.x[ANGLES] = Rotation.from_matrix(navigator.pose.world_from_body[:3, :3]).as_euler("ZYX")[::-1]
        self.x[VELOCITY] = navigator.velocity.linear_body_m_s
        spread = (POSITION_STD_M, 0.02, VELOCITY_STD_M_S, 0.05, 0.3)
        self.P = np.diag(np.repeat(spread, 3) ** 2)
        self.P[5, 5] = 0.1**2  # the first heading

    def follow(self, samples: Sequence[Sample], time_s: float) -> None:
        """Receive samples, then propagate to a time."""
        for stamp_ns, kind, reading in samples:
            self.receive(stamp_ns * 1e-9, kind, reading)
        self.predict(time_s)

    def predict(self, time_s: float) -> None:
        """Propagate state and covariance to a time; late samples, such as the DVL's, do not move it back in time."""
        dt = time_s - self._time_s
        if dt > 0:
            self._time_s = time_s
            self.F = slope(lambda x: moved(x, dt), self.x)
            self.x = moved(self.x, dt)
            self.P = self.F @ self.P @ self.F.T + np.diag(self._noise * dt)

    def receive(self, time_s: float, kind: str, reading: Floats) -> None:
        """Correct the state by a sample."""
        self.predict(time_s)
        sensor = self._sensors[kind]
        lever = np.asarray(sensor.spec.position_m)
        if kind == "imu":
            roll, pitch = Rotation.from_quat(reading[6:10]).as_euler("ZYX")[2:0:-1]
            rate_std, force_std, level_std = (
                whole_std(sensor, key) for key in ("angular_velocity", "linear_acceleration", "orientation")
            )
            up = np.array([0.0, 0.0, self._gravity_m_s2])

            def expected(x: Floats) -> Floats:
                force = x[..., FORCES] + turn(x).swapaxes(-1, -2) @ up
                return np.concatenate([x[..., RATES], force, x[..., 3:5]], axis=-1)

            spread = np.repeat((rate_std, force_std, level_std), (3, 3, 2))
            self._correct(np.array([*reading[:6], roll, pitch]), expected, spread)
        elif kind == "dvl":
            std = whole_std(sensor, "beam_velocity")
            slant = math.radians(sensor.spec.parameters["beam_slant_deg"][0])
            spread = std * np.array([1 / (math.sqrt(2) * math.sin(slant))] * 2 + [1 / (2 * math.cos(slant))])
            self._correct(reading[:3], lambda x: x[..., VELOCITY] + np.cross(x[..., RATES], lever), spread)
        elif kind == "depth":
            at = -float(reading[0])
            self._correct(
                np.array([at]), lambda x: (x[..., POSITION] + turn(x) @ lever)[..., 2:], whole_std(sensor, "depth")
            )
        elif kind == "compass":
            yaw = north_rad(sensor) - float(reading[0])
            yaw += 2 * math.pi * round((self.x[5] - yaw) / (2 * math.pi))
            iron = np.hypot.reduce(sensor.spec.parameters["hard_iron_ut"][:2]) / 20.0
            self._correct(np.array([yaw]), lambda x: x[..., 5:6], math.hypot(whole_std(sensor, "heading"), iron))
        else:
            fix, range_m = reading[:3] + reading[6:9], float(reading[3])
            sight = reading[:3] / range_m
            along, across = whole_std(sensor, "range"), whole_std(sensor, "bearing") * range_m
            variance = across**2 * np.eye(3) + (along**2 - across**2) * np.outer(sight, sight)
            self._correct(fix, lambda x: x[..., POSITION] + turn(x) @ lever, variance)

    def _correct(self, z: Floats, measure: Measure, spread: float | Floats) -> None:
        """spread: standard deviation of each component, or their covariance."""
        matrix = np.ndim(spread) == 2
        noise = np.asarray(spread) if matrix else np.diag(np.broadcast_to(np.square(spread), z.shape))
        self._I = np.eye(15)
        self.update(z, lambda x: slope(measure, x), measure, R=noise)


def turn(x: Floats) -> Floats:
    """Return world-from-body rotations (..., 3, 3) for states (..., 15)."""
    angles = x[..., ANGLES]
    return np.asarray(Rotation.from_euler("ZYX", angles[..., ::-1].reshape(-1, 3)).as_matrix()).reshape(
        *x.shape[:-1], 3, 3
    )


def moved(x: Floats, dt: float) -> Floats:
    """Return states (..., 15) after dt seconds of constant acceleration and constant rates."""
    after = x.copy()
    roll, pitch = x[..., 3], x[..., 4]
    p, q, r = (x[..., 9 + k] for k in range(3))
    about = q * np.sin(roll) + r * np.cos(roll)
    euler_rates = (p + about * np.tan(pitch), q * np.cos(roll) - r * np.sin(roll), about / np.cos(pitch))
    shift = x[..., VELOCITY] * dt + 0.5 * x[..., FORCES] * dt**2
    after[..., POSITION] += np.einsum("...ij,...j->...i", turn(x), shift)
    after[..., ANGLES] += dt * np.stack(euler_rates, axis=-1)
    after[..., VELOCITY] += dt * x[..., FORCES]
    return after


def slope(function: Measure, x: Floats) -> Floats:
    """Return the derivative (m, 15) by central differences."""
    nudge = 1e-6 * np.eye(15)
    return np.asarray((function(x + nudge) - function(x - nudge)).T / 2e-6)
