"""Arrays of hydrophones on a vehicle: the raw samples of a converter, in a window around each ping of a pinger."""

from __future__ import annotations

import io
import math
import wave
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.base import quaternions
from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.motion import Pose, Velocity
from uwsim.base.sealed import Attached
from uwsim.base.short_repr import ShortRepr
from uwsim.instruments.acoustics.pinger_sound import Burst, PingerSound, tone
from uwsim.instruments.errors import normal_draws
from uwsim.scenario.spec.pinger import HydrophoneArray

COUNTS = 32768


class Body(Protocol):
    """The part of a vehicle that its hydrophones need."""

    @property
    def name(self) -> str:
        """The vehicle's name."""

    @property
    def pose(self) -> Pose:
        """Its present pose."""

    @property
    def velocity(self) -> Velocity:
        """Its present velocity."""


@dataclass(frozen=True, eq=False, repr=False)
class HydrophonePing(ShortRepr):
    """The window around one ping. samples (n, phones) int16: the converter's counts, clipped at its full scale.

    rate_hz: of the samples. start_s: simulated time of the first. pascals_per_count: the pressure in the water.
    """

    samples: NDArray[np.int16]
    rate_hz: float
    start_s: float
    pascals_per_count: float

    @property
    def times_s(self) -> Floats:
        """The simulated time of each sample, (n,)."""
        return self.start_s + np.arange(len(self.samples)) / self.rate_hz

    @property
    def clipped(self) -> int:
        """The number of samples at the limits of the converter."""
        return int(((self.samples == COUNTS - 1) | (self.samples == -COUNTS)).sum())

    def save(self, path: str | Path) -> None:
        """Write the samples as .wav (16 bits, a channel for each hydrophone) or .csv (time_s, phone_0 ...).

        Raises ValueError for any other suffix, OSError if the file cannot be written.
        """
        target = Path(path)
        if target.suffix not in (".wav", ".csv"):
            raise ValueError(f"{target}: must end in .wav or .csv")
        write_atomically(target, self._wav() if target.suffix == ".wav" else self._csv())

    def _wav(self) -> bytes:
        content = io.BytesIO()
        with wave.open(content, "wb") as file:
            file.setnchannels(self.samples.shape[1])
            file.setsampwidth(2)
            file.setframerate(round(self.rate_hz))
            file.writeframes(self.samples.astype("<i2").tobytes())
        return content.getvalue()

    def _csv(self) -> bytes:
        phones, content = self.samples.shape[1], io.StringIO()
        head = ",".join(["time_s", *(f"phone_{k}" for k in range(phones))])
        rows = np.column_stack([self.times_s, self.samples])
        np.savetxt(content, rows, ["%.9f", *["%d"] * phones], ",", header=head, comments="")
        return content.getvalue().encode()


class Hydrophones(Attached):
    """An array of one to four hydrophones on a vehicle.

    Its samples are computed when it is read, and depends on the vehicle's motion at that time: where the vehicle was
    when the sound arrived follows from its present pose and velocity. Read it soon after each ping, or subscribe to its
    topic, which reads it 20 times per second. spec: its mount and its electronics.
    """

    name: str
    spec: HydrophoneArray

    def __init__(
        self, body: Body, name: str, spec: HydrophoneArray, sound: PingerSound, time_s: Callable[[], float],
        seed: Callable[[], int],
    ) -> None:  # fmt: skip
        """time_s, seed: return the simulated time and the run's seed."""
        self._body, self._sound, self._time_s, self._seed = body, sound, time_s, seed
        turn = quaternions.matrix(quaternions.of_yaw_pitch_roll_deg(spec.yaw_pitch_roll_deg))
        self._phones_body_m = np.array(spec.phones_m) @ turn.T + spec.position_m
        self.name = name
        self.spec = spec

    def __repr__(self) -> str:
        return f"<Hydrophones '{self.name}': {len(self.spec.phones_m)} at {self.spec.rate_hz:g} Hz>"

    def newest(self) -> Burst | None:
        """Return the last ping whose window has ended, or None before the first."""
        return self._sound.last_burst(
            lambda when_s: self._phones_m(when_s).mean(axis=0), self._time_s() - self.spec.after_s
        )

    def listen(self) -> HydrophonePing | None:
        """Return the samples around the last ping whose window has ended, or None before the first."""
        burst = self.newest()
        return None if burst is None else self.samples_of(burst)

    def samples_of(self, burst: Burst) -> HydrophonePing:
        """Return the samples around a ping; repeated at one time, they are the same."""
        spec = self.spec
        first = max(0, math.floor((burst.arrival_s - spec.before_s) * spec.rate_hz))
        count = max(1, round((spec.before_s + spec.after_s) * spec.rate_hz))
        times_s = (first + np.arange(count)) / spec.rate_hz
        pressure = self._noise(first, count)
        points_m = self._phones_m(burst.arrival_s)
        for pinger in self._sound.pingers:
            for phone, paths in enumerate(self._sound.paths(pinger, points_m)):
                for delay_s, gain, phase_rad in zip(paths.delay_s, paths.gain, paths.phase_rad, strict=True):
                    earliest_s, latest_s = times_s[0] - delay_s - pinger.pulse_s, times_s[-1] - delay_s
                    lowest = max(0, math.ceil((earliest_s - pinger.first_s) / pinger.period_s))
                    for number in range(lowest, math.floor((latest_s - pinger.first_s) / pinger.period_s) + 1):
                        begin_s = pinger.first_s + number * pinger.period_s + delay_s
                        a, b = np.searchsorted(times_s, (begin_s, begin_s + pinger.pulse_s))
                        pressure[a:b, phone] += gain * tone(pinger, times_s[a:b] - begin_s, phase_rad)
        volts = spec.volts_per_micropascal * pressure
        counts = np.clip(np.round(volts * (COUNTS / spec.full_scale_v)), -COUNTS, COUNTS - 1).astype(np.int16)
        pascals = 1e-6 * spec.full_scale_v / (COUNTS * spec.volts_per_micropascal)
        return HydrophonePing(counts, spec.rate_hz, first / spec.rate_hz, pascals)

    def _phones_m(self, when_s: float) -> Floats:
        """Return the places of the hydrophones at a time, (n, 3), in the world, if the vehicle's motion is steady."""
        pose, velocity = self._body.pose, self._body.velocity
        since_s = when_s - self._time_s()
        angle = since_s * velocity.angular_body_rad_s
        size = float(np.linalg.norm(angle))
        half = np.sin(0.5 * size) / size if size > 0.0 else 0.5
        turn = quaternions.matrix([*(half * angle), math.cos(0.5 * size)])
        points = self._phones_body_m @ turn.T + since_s * velocity.linear_body_m_s
        world: Floats = points @ pose.world_from_body[:3, :3].T + pose.position_world_m
        return world

    def _noise(self, first: int, count: int) -> Floats:
        """Return noise (count, phones) [uPa], ambient and the electronics', independent from phone to phone."""
        phones = len(self.spec.phones_m)
        stream = f"hydrophones/{self._body.name}/{self.name}"
        white = normal_draws(self._seed(), stream, first, phones * count).reshape(phones, count)
        frequencies = np.asarray(np.fft.rfftfreq(count, 1.0 / self.spec.rate_hz), np.float64)
        density = 10.0 ** (0.1 * self._sound.noise_db(frequencies)) + 10.0 ** (0.1 * self.spec.noise_db)
        shaped = np.fft.irfft(np.fft.rfft(white) * np.sqrt(0.5 * self.spec.rate_hz * density), count)
        return np.ascontiguousarray(shaped.T)
