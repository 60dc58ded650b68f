"""make_sequence: flies a mission and writes the measurements of the instruments; `uwsim dataset --sequence` calls it.

The files are written to a folder beside the requested one, which is renamed once the sequence is complete.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping
from collections.abc import Sequence as Names
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.base.agenda import Rank, next_tick
from uwsim.base.atomic_file import unfinished
from uwsim.base.folder_lock import LOCK, alone_in
from uwsim.base.own_files import is_own, mark
from uwsim.campaigns.datasets.sequences.calibration import camera_chain, imu_noise, kalibr_imu, mounted
from uwsim.campaigns.datasets.sequences.euroc import write_yaml
from uwsim.campaigns.datasets.sequences.instruments import Imaged, Instrument, Pinged, Sampled, Seen, Truth
from uwsim.channels import Channel, Table
from uwsim.channels.delivery.feed import Reading
from uwsim.channels.source import Source
from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.flight.missions import AnyMission
from uwsim.flight.record import FlightRecord
from uwsim.flight.terminal import Silent
from uwsim.live import Subscription
from uwsim.recording.bag_sink import BagSink
from uwsim.scenario import Scenario, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.simulator.simulator import Simulator

ABOUT, BAG, TRUTH, CHAIN, IMU = "sequence.json", "sequence.bag", "groundtruth.tum", "camchain-imucam.yaml", "imu.yaml"
UNFINISHED = ".unfinished"
"""Ends the name of the folder in which a sequence is written until it is complete."""


@dataclass(frozen=True, eq=False)
class Sequence:
    """A complete sequence in the folder `out`.

    counts: the number of samples, pictures or pings of each instrument, by its folder in mav0. flight: the record of
    the mission.
    """

    out: Path
    counts: dict[str, int]
    flight: FlightRecord


def make_sequence(
    scenario: str | Path | Scenario,
    mission: str | Path | AnyMission,
    out: str | Path,
    *,
    cameras: Names[str] = ("front",),
    vehicle: str | None = None,
    seed: int | None = None,
    time_limit_s: float | None = None,
    threads: int | None = None,
    screen: Silent | None = None,
) -> Sequence:
    """Fly a mission and write all that the vehicle's instruments measure, in EuRoC's layout and as a ROS 1 bag.

        uwsim.make_sequence("lake", "my_mission.py", "sequence", cameras=("front", "down"))

    mission: the mission, as for uwsim.flight.fly.fly. out: a new folder. cameras: names of the vehicle's cameras. The
    same scenario, seed and mission give the same bytes, whatever the number of threads. If the flight fails or is
    interrupted, its files are removed; a folder whose name ends in ".unfinished" was left by a killed process, and the
    next run removes it.

    Raises ScenarioError or ValueError before anything is written, for example for a camera that EuRoC's model cannot
    describe; ValueError if the flight was interrupted or a camera was turned; OSError; and the mission's own errors.
    """
    into = Path(out)
    if into.exists() and (not into.is_dir() or any(into.iterdir())):
        raise ValueError(f"--out {into}: exists already: choose another, or remove it")
    sim = Simulator(load(scenario), seed=seed, threads=threads)
    table = Table(sim)
    source = _source(table, sim, vehicle)
    for name in cameras:
        source.of(sim).cameras[name]  # raises a KeyError that lists the existing names
    with _made(into) as folder:
        taken = _Taken(folder, table, source, sim, cameras)
        taken.start()
        try:
            flight = fly(
                mission, sim, vehicles=(source.name,), report="none", autosave_s=0.0, time_limit_s=time_limit_s,
                sample_sensors=False, screen=screen,
            )  # fmt: skip
        finally:
            taken.finish()
        taken.require_whole()
        if flight.interrupted:
            raise ValueError("the flight was interrupted: no sequence is left")
        counts = taken.counts
        _describe(folder, sim, source, taken, flight)
    return Sequence(into, counts, flight)


def _source(table: Table, sim: Simulator, vehicle: str | None) -> Source:
    name = sim.vehicles[vehicle].name if vehicle is not None else sim.rov.name
    return next(each for each in table.sources if each.name == name)


@contextmanager
def _made(into: Path) -> Iterator[Path]:
    """Yield a folder beside `into`; rename it to `into` after the block, or remove it if the block fails."""
    folder = into.with_name(into.name + UNFINISHED)
    if folder.is_dir() and not is_own(folder) and any(folder.iterdir()):
        raise ValueError(f"--out {into}: '{folder.name}' is beside it, and uwsim did not make it: choose another --out")
    mark(made_folder(folder), unfinished=True)
    with alone_in(folder), unfinished(folder):
        for left in folder.iterdir():  # left by a process that was killed
            if left.name != LOCK:
                shutil.rmtree(left) if left.is_dir() else left.unlink()
        try:
            yield folder
            (folder / LOCK).unlink()
            folder.replace(into)
        except BaseException:
            with suppress(OSError):
                shutil.rmtree(folder)
            raise


class _Taken:
    """All instruments of a vehicle in flight."""

    def __init__(self, folder: Path, table: Table, source: Source, sim: Simulator, cameras: Names[str]) -> None:
        self._sim, self._bag = sim, BagSink(folder / BAG, compressed=False)
        self._bag_channels: dict[str, int] = {}
        vehicle, mav = source.of(sim), folder / "mav0"
        channels = {channel.name: channel for channel in table.channels}
        self.cameras = [Seen(mav / f"cam{k}", source, table, sim, name, self._say) for k, name in enumerate(cameras)]
        self.sensors = [
            Sampled(mav / _numbered(mav, sensor.kind), source, sim, name, self._say, channels.get(source.topic(name)))
            for name, sensor in vehicle.sensors.items()
        ]
        self.instruments: list[Instrument] = [
            Truth(mav / "state_groundtruth_estimate0", folder / TRUTH, source, table, self._say),
            *self.sensors, *self.cameras,
        ]  # fmt: skip
        if source.has_sonar:
            self.instruments.append(Pinged(mav / "multibeam0", source, table, sim, self._say))
        for name, sonar in vehicle.imaging_sonars.items():
            kind = type(sonar.model).__name__.lower()
            self.instruments.append(Imaged(mav / _numbered(mav, kind), source, table, sim, name, self._say))
        self._subscriptions = [
            Subscription(sim, round(1e9 / each.rate_hz), each.read, lambda _: None) for each in self.instruments
        ]
        frames = channels["tf_static"]
        self._say(frames, frames.read(sim), sim.time_ns)

    @property
    def counts(self) -> dict[str, int]:
        """The number of samples by instrument."""
        return {each.folder.name: each.count for each in self.instruments}

    def start(self) -> None:
        """Read all instruments at their rates, starting after one step, when a mission that undocks has done so."""
        step_ns = round(self._sim.step_s * 1e9)
        for each, subscription in zip(self.instruments, self._subscriptions, strict=True):
            subscription.due_tick = next_tick(self._sim.tick, round(1e9 / each.rate_hz), step_ns)
            self._sim.agenda.add(subscription, Rank.OBSERVER, subscription.act)

    def finish(self) -> None:
        """Stop reading, and close all files. Raises OSError."""
        for subscription in self._subscriptions:
            subscription.cancel()
        try:
            for each in self.instruments:
                each.close()
        finally:
            self._bag.close({})

    def require_whole(self) -> None:
        """Raise the first error of an instrument."""
        for subscription in self._subscriptions:
            if subscription.error is not None:
                raise subscription.error

    def _say(self, channel: Channel, message: Any, time_ns: int) -> None:
        if channel.name not in self._bag_channels:
            self._bag.add_channel(channel)
            self._bag_channels[channel.name] = 0
        number = self._bag_channels[channel.name]
        self._bag_channels[channel.name] = number + 1
        data = self._bag.encode(Reading(channel, message, time_ns, self._sim.tick))
        self._bag.write(channel.name, time_ns, number, data)


def _numbered(mav: Path, kind: str) -> str:
    return next(name for k in range(1000) if not (mav / (name := f"{kind}{k}")).exists())


def _describe(folder: Path, sim: Simulator, source: Source, taken: _Taken, flight: FlightRecord) -> None:
    """Write Kalibr's files, and sequence.json with a digest of every other file."""
    imu = next((each for each in taken.sensors if each.sensor.kind == "imu"), None)
    from_imu = None if imu is None else mounted(imu.mount.position_m, imu.mount.yaw_pitch_roll_deg)
    seen = {each.name: (each.info, each.body_from_optical) for each in taken.cameras if each.info is not None}
    if seen:
        write_yaml(folder / CHAIN, camera_chain(seen, {each.name: each.topic for each in taken.cameras}, from_imu))
    if imu is not None:
        write_yaml(folder / IMU, kalibr_imu(imu_noise(imu.mount, imu.sensor), source.topic(imu.name)))
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != LOCK)
    about: Mapping[str, Any] = {
        "scenario": sim.scenario.name,
        "scenario_digest": scenario_fingerprint(sim.scenario),
        "seed": sim.seed,
        "build": build_fingerprint(),
        "vehicle": source.name,
        "cameras": [each.name for each in taken.cameras],
        "simulated_s": flight.simulated_s,
        "ended_because": flight.ended_because,
        "counts": taken.counts,
        "files": {str(path.relative_to(folder)): _digest(path) for path in files},
    }
    (folder / ABOUT).write_text(json.dumps(about, indent=1) + "\n")


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
