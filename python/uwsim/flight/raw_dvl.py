"""A flight's Doppler log as a file for others' software: `uwsim survey --raw FILE.pd0`."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.flight.raw_places import Array, angles
from uwsim.instruments.sample_stream import SampleStream
from uwsim.instruments.sonars.soundings import sound_speed_profile
from uwsim.mapping.files.dvl_ensemble import DvlEnsemble, DvlHead, DvlWriter, WaterCells
from uwsim.mapping.files.swath import EPOCH_NS
from uwsim.scenario.build.cast import require_temperature
from uwsim.simulator.simulator import Simulator

DVL, ADCP = "dvl", "adcp"
AXES = np.array([1.0, -1.0, 1.0])  # forward, starboard and up of a sensor's axes
LOST = np.full(3, np.nan)


class RawDvl:
    """Writes each sample of the first vehicle's first DVL from the first mapped ping on; `add` is a TakePing.

    With an ADCP, a ping has the cells of its latest sample since the ping before; a vehicle that has only an ADCP has a
    ping for each of its samples, without a bottom track. A sample's attitude and depth are those of the flight's map,
    interpolated between its pings. `count` is that of the pings. Raises ValueError for a vehicle that has neither.
    """

    def __init__(self, sim: Simulator, path: Path, write: Callable[[Path, DvlHead], DvlWriter]) -> None:
        self._sim, self._path, self._write = sim, path, write
        first = {each.kind: each for each in reversed(list(sim.rov.sensors.values())) if each.kind in (DVL, ADCP)}
        if not first:
            raise ValueError(
                f"--raw {path}: holds a Doppler log: '{sim.rov.name}' must have a sensor of kind {DVL} or {ADCP}"
            )
        self._sensors = [first[kind] for kind in (DVL, ADCP) if kind in first]  # the first gives the pings
        require_temperature(sim.parameters.scenario.water, f"--raw {path}")
        self._water = sound_speed_profile(sim.world.water)
        self._streams: list[SampleStream] = []
        self._cells: list[tuple[int, Array]] = []  # times and readings that no ping has yet
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
        if self._file is None:
            self._streams = [sensor.stream(self._sim.time_ns) for sensor in self._sensors]
            self._file = self._write(self._path, self._head())
        self._put()
        self.count += 1

    def close(self) -> None:
        """Complete the file. Raises ValueError if no ping was taken."""
        if self._file is None:
            raise ValueError(f"--raw {self._path}: no ping was taken, and nothing written")
        self._put()
        for stream in self._streams:
            stream.close()
        self._file.close()

    def discard(self) -> None:
        """Remove what was written of a flight that failed."""
        for stream in self._streams:
            stream.close()
        if self._file is not None:
            self._file.discard()

    def _head(self) -> DvlHead:
        head, *_ = self._sensors
        (slant_deg,) = head.spec.parameters["beam_slant_deg"]
        cells = None
        if self._sensors[-1].kind == ADCP:
            of = {name: values[0] for name, values in self._sensors[-1].spec.parameters.items()}
            cells = WaterCells(
                int(of["cell_count"]), of["cell_size_m"], of["blanking_m"] + 0.5 * of["cell_size_m"],
                (of["layer_near_m"], of["layer_far_m"]),
            )  # fmt: skip
        return DvlHead(self._sim.rov.name, head.name, math.radians(slant_deg), head.period_s, cells)

    def _put(self) -> None:
        assert self._file is not None
        times, *rest = np.array(self._poses, np.float64).T
        new = [stream.take() for stream in self._streams]
        if self._sensors[-1].kind == ADCP:
            self._cells += zip(new[-1].stamps_ns.tolist(), np.asarray(new[-1].readings, np.float64), strict=True)
        water = self._sim.world.water
        for stamp_ns, is_valid, reading in zip(
            new[0].stamps_ns.tolist(), new[0].valid.tolist(), np.asarray(new[0].readings, np.float64), strict=True
        ):
            heading, pitch, roll, depth_m = (float(np.interp(stamp_ns, times, each)) for each in rest)
            cells, track = self._water_until(stamp_ns)
            self._file.add(DvlEnsemble(
                time_ns=EPOCH_NS + stamp_ns, heading_rad=heading, pitch_rad=pitch, roll_rad=roll, depth_m=depth_m,
                sound_speed_m_s=self._water.at(max(0.0, depth_m)), salinity_psu=water.salinity_at_psu(-depth_m),
                temperature_deg_c=water.temperature_deg_c(-depth_m), pressure_pa=water.pressure_pa(-depth_m),
                cells_m_s=cells, water_track_m_s=track, **self._bottom(reading, is_valid),
            ))  # fmt: skip

    def _bottom(self, reading: Array, is_valid: bool) -> dict[str, Array]:
        if self._sensors[0].kind != DVL:
            lost = np.full(4, np.nan)
            return {"velocity_m_s": LOST, "beam_velocities_m_s": lost, "beam_ranges_m": lost}
        velocity, ranges, along = reading[:3], reading[3:7], reading[7:11]
        seen = np.isfinite(ranges)
        return {
            "velocity_m_s": velocity * AXES if is_valid else LOST, "beam_velocities_m_s": np.where(seen, along, np.nan),
            "beam_ranges_m": np.where(seen, ranges, np.nan),
        }  # fmt: skip

    def _water_until(self, stamp_ns: int) -> tuple[Array | None, Array | None]:
        """Return cells and water track of the latest sample that no ping has had, and forget it and those before."""
        arrived = [reading for at_ns, reading in self._cells if at_ns <= stamp_ns]
        self._cells = self._cells[len(arrived) :]
        if not arrived:
            return None, None
        reading = arrived[-1]
        count = int(self._sensors[-1].spec.parameters["cell_count"][0])
        cells = reading[3:-1].reshape(-1, 3)[:count] * AXES
        return cells, reading[:3] * AXES if reading[-1] else LOST
