"""A flight's Doppler log as a file for others' software: `uwsim survey --raw FILE.pd0`."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.flight.raw_places import Array, angles
from uwsim.instruments.sample_stream import Samples, SampleStream
from uwsim.instruments.sonars.soundings import sound_speed_profile
from uwsim.mapping.files.dvl_ensemble import DvlEnsemble, DvlHead, DvlWriter
from uwsim.mapping.files.swath import EPOCH_NS
from uwsim.simulator.simulator import Simulator

DVL = "dvl"


class RawDvl:
    """Writes each sample of the first vehicle's first DVL from the first mapped ping on; `add` is a TakePing.

    A sample's attitude and depth are those of the flight's map, interpolated between its pings. `count` is that of the
    pings. Raises ValueError for a vehicle without a DVL.
    """

    def __init__(self, sim: Simulator, path: Path, write: Callable[[Path, DvlHead], DvlWriter]) -> None:
        self._sim, self._path, self._write = sim, path, write
        found = [each for each in sim.rov.sensors.values() if each.kind == DVL]
        if not found:
            raise ValueError(f"--raw {path}: holds a Doppler log: '{sim.rov.name}' must have a sensor of kind dvl")
        self._sensor = found[0]
        self._water = sound_speed_profile(sim.world.water)
        self._stream: SampleStream | None = None
        self._file: DvlWriter | None = None
        self._poses: list[tuple[int, float, float, float, float]] = []
        self.count = 0

    def add(self, ping: Any, panel: object, world_from_body: Array) -> None:
        """Write the samples that have arrived, at the attitudes up to this ping's pose (4, 4)."""
        body = np.asarray(world_from_body, np.float64)
        roll, pitch, yaw = angles(body[:3, :3])
        heading = math.pi / 2 - yaw
        if self._poses:
            heading += math.tau * round((self._poses[-1][1] - heading) / math.tau)
        self._poses = [*self._poses[-1:], (self._sim.time_ns, heading, -pitch, roll, -float(body[2, 3]))]
        if self._stream is None:
            self._stream = self._sensor.stream(self._sim.time_ns)
            self._file = self._write(self._path, self._head())
        self._put(self._stream.take())
        self.count += 1

    def close(self) -> None:
        """Complete the file. Raises ValueError if no ping was taken."""
        if self._file is None or self._stream is None:
            raise ValueError(f"--raw {self._path}: no ping was taken, and nothing written")
        self._put(self._stream.take())
        self._stream.close()
        self._file.close()

    def discard(self) -> None:
        """Remove what was written of a flight that failed."""
        if self._stream is not None:
            self._stream.close()
        if self._file is not None:
            self._file.discard()

    def _head(self) -> DvlHead:
        (slant_deg,) = self._sensor.spec.parameters["beam_slant_deg"]
        return DvlHead(self._sim.rov.name, self._sensor.name, math.radians(slant_deg), self._sensor.period_s)

    def _put(self, samples: Samples) -> None:
        assert self._file is not None
        times, *rest = np.array(self._poses, np.float64).T
        for stamp_ns, is_valid, reading in zip(
            samples.stamps_ns.tolist(), samples.valid.tolist(), np.asarray(samples.readings, np.float64), strict=True
        ):
            heading, pitch, roll, depth_m = (float(np.interp(stamp_ns, times, each)) for each in rest)
            velocity, ranges, along = reading[:3], reading[3:7], reading[7:11]
            seen = np.isfinite(ranges)
            water = self._sim.world.water
            self._file.add(DvlEnsemble(
                time_ns=EPOCH_NS + stamp_ns, heading_rad=heading, pitch_rad=pitch, roll_rad=roll, depth_m=depth_m,
                sound_speed_m_s=self._water.at(max(0.0, depth_m)), salinity_psu=water.salinity_at_psu(-depth_m),
                temperature_deg_c=water.temperature_deg_c(-depth_m), pressure_pa=water.pressure_pa(-depth_m),
                velocity_m_s=velocity * [1.0, -1.0, 1.0] if is_valid else np.full(3, np.nan),
                beam_velocities_m_s=np.where(seen, along, np.nan), beam_ranges_m=np.where(seen, ranges, np.nan),
            ))  # fmt: skip
