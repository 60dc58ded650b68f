"""make_sequence: flies a mission and writes the measurements of the instruments; `uwsim dataset --sequence` calls it.

The files are written to a folder beside the requested one, which is renamed once the sequence is complete.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import time
from collections.abc import Iterator, Mapping
from collections.abc import Sequence as Names
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from uwsim.base.agenda import Rank, next_tick
from uwsim.base.atomic_file import unfinished
from uwsim.base.folder_lock import LOCK, alone_in
from uwsim.base.named import did_you_mean
from uwsim.base.own_files import is_own, mark
from uwsim.campaigns.datasets.sequences.baselines import Baselines
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
from uwsim.recording.sink import Batch
from uwsim.scenario import AnyScenario, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.simulator.simulator import Simulator

ABOUT, BAG, TRUTH, CHAIN, IMU = "sequence.json", "sequence.bag", "groundtruth.tum", "camchain-imucam.yaml", "imu.yaml"
MULTIBEAM, COST_AFTER_S = "multibeam", 2.0
UNFINISHED = ".unfinished"
"""Ends the name of the folder in which a sequence is written until it is complete."""


@dataclass(frozen=True, eq=False)
class Sequence:
    """A complete sequence in the folder `out`.

    counts: the number of samples, pictures or pings of each instrument, by its folder in mav0. flight: the record of
    the mission. baselines: the errors of uwsim's own estimates [m], by baseline; see datasets.sequences.baselines.
    """

    out: Path
    counts: dict[str, int]
    flight: FlightRecord
    baselines: dict[str, dict[str, float]] = field(default_factory=dict)

    def __repr__(self) -> str:
        counts = ", ".join(f"{count:,} {name}" for name, count in self.counts.items())
        return f"<Sequence '{self.out}': {self.flight.simulated_s:.1f} s, {counts}>"


def make_sequence(
    scenario: AnyScenario,
    mission: str | Path | AnyMission,
    out: str | Path,
    *,
    cameras: Names[str] = ("front",),
    instruments: Names[str] | None = None,
    without: Names[str] = (),
    bag: bool = True,
    baselines: bool = False,
    vehicle: str | None = None,
    seed: int | None = None,
    time_limit_s: float | None = None,
    threads: int | None = None,
    screen: Silent | None = None,
) -> Sequence:
    """Fly a mission and write all that the vehicle's instruments measure, in EuRoC's layout and as a ROS 1 bag.

        uwsim.make_sequence("lake", "my_mission.py", "sequence", cameras=("front", "down"))

    mission: the mission, as for uwsim.flight.fly.fly. out: a new folder. cameras: names of the vehicle's cameras.
    instruments: names of its sensors and imaging sonars, and multibeam; None: all; the ground truth is always written.
    without: instruments to leave out. bag: whether to write sequence.bag, which takes as much space as the rest.
    baselines: whether to write uwsim's own estimates, too, for a mission that undocks at its start. The
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
    chosen = _chosen(source, sim, instruments, without)
    with _made(into) as folder:
        taken = _Taken(
            folder, table, source, sim, cameras, chosen, bag=bag, baselines=baselines,
            screen=screen or Silent(),
        )  # fmt: skip
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
    return Sequence(into, counts, flight, taken.errors)


def _chosen(source: Source, sim: Simulator, instruments: Names[str] | None, without: Names[str]) -> set[str]:
    """Return the names of the instruments to write, of sensors, imaging sonars, and multibeam. Raises ValueError."""
    vehicle = source.of(sim)
    known = [*vehicle.sensors, *([MULTIBEAM] if source.has_sonar else []), *vehicle.imaging_sonars]
    for name in (*(instruments or ()), *without):
        if name not in known:
            raise ValueError(f"instrument '{name}': must be one of {', '.join(known)}{did_you_mean(name, known)}")
    return set(known if instruments is None else instruments) - set(without)


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

    def __init__(
        self, folder: Path, table: Table, source: Source, sim: Simulator, cameras: Names[str], chosen: set[str], *,
        bag: bool, baselines: bool, screen: Silent,
    ) -> None:  # fmt: skip
        self._sim, self._bag = sim, BagSink(folder / BAG, compressed=False) if bag else None
        self._folder, self._screen = folder, screen
        self._bag_channels: dict[str, int] = {}
        vehicle, mav = source.of(sim), folder / "mav0"
        channels = {channel.name: channel for channel in table.channels}
        self.cameras = [Seen(mav / f"cam{k}", source, table, sim, name, self._say) for k, name in enumerate(cameras)]
        self.sensors = [
            Sampled(mav / _numbered(mav, sensor.kind), source, sim, name, self._say, channels.get(source.topic(name)))
            for name, sensor in vehicle.sensors.items()
            if name in chosen
        ]
        self.instruments: list[Instrument] = [
            Truth(mav / "state_groundtruth_estimate0", folder / TRUTH, source, table, self._say),
            *self.sensors, *self.cameras,
        ]  # fmt: skip
        if MULTIBEAM in chosen:
            self.instruments.append(Pinged(mav / "multibeam0", source, table, sim, self._say))
        for name in [each for each in vehicle.imaging_sonars if each in chosen]:
            kind = type(vehicle.imaging_sonars[name].model).__name__.lower()
            self.instruments.append(Imaged(mav / _numbered(mav, kind), source, table, sim, name, self._say))
        self._baselines = Baselines(folder, source, table) if baselines else None
        self._readers: list[Instrument | Baselines] = [
            *self.instruments,
            *([self._baselines] if self._baselines is not None else []),
        ]
        self._subscriptions = [
            Subscription(sim, round(1e9 / each.rate_hz), each.read, lambda _: None) for each in self._readers
        ]
        self._first = Subscription(sim, round(1e9 * COST_AFTER_S), self._show_cost, lambda _: None)
        frames = channels["tf_static"]
        self._say(frames, frames.read(sim), sim.time_ns)

    @property
    def counts(self) -> dict[str, int]:
        """The number of samples by instrument."""
        return {each.folder.name: each.count for each in self.instruments}

    @property
    def errors(self) -> dict[str, dict[str, float]]:
        """The errors of the baselines."""
        return {} if self._baselines is None else self._baselines.errors

    def start(self) -> None:
        """Read all instruments at their rates, starting after one step, when a mission that undocks has done so."""
        step_ns = round(self._sim.step_s * 1e9)
        for each, subscription in zip(self._readers, self._subscriptions, strict=True):
            subscription.due_tick = next_tick(self._sim.tick, round(1e9 / each.rate_hz), step_ns)
            self._sim.agenda.add(subscription, Rank.OBSERVER, subscription.act)
        self._first.due_tick = self._sim.tick + round(COST_AFTER_S / self._sim.step_s)
        self._sim.agenda.add(self._first, Rank.OBSERVER, self._first.act)
        self._begun_s = time.perf_counter()

    def _show_cost(self, sim: Simulator) -> None:
        """Show once what a simulated second costs, so that a long sequence can be stopped before it fills a disk."""
        self._first.cancel()
        took_s = (time.perf_counter() - self._begun_s) / COST_AFTER_S
        megabytes = 1e-6 * sum(path.stat().st_size for path in self._folder.rglob("*")) / COST_AFTER_S
        rule = f"{took_s:.2g} s and {megabytes:.2g} MB for each simulated second"
        self._screen.message(f"the first {COST_AFTER_S:g} s: {rule}; --without, --no-bag and --time-limit save some")

    def finish(self) -> None:
        """Stop reading, and close all files. Raises OSError."""
        for subscription in (*self._subscriptions, self._first):
            subscription.cancel()
        try:
            for each in self._readers:
                each.close()
        finally:
            if self._bag is not None:
                self._bag.close({})

    def require_whole(self) -> None:
        """Raise the first error of an instrument."""
        for subscription in self._subscriptions:
            if subscription.error is not None:
                raise subscription.error

    def _say(self, channel: Channel, message: Any, time_ns: int) -> None:
        if self._bag is None:
            return
        if channel.name not in self._bag_channels:
            self._bag.add_channel(channel)
            self._bag_channels[channel.name] = 0
        number = self._bag_channels[channel.name]
        self._bag_channels[channel.name] = number + 1
        data = self._bag.encode(Reading(channel, message, time_ns, self._sim.tick))
        self._bag.write(Batch.of([(channel.name, time_ns, number, data)]))


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
        **({"baselines": taken.errors} if taken.errors else {}),
        "files": {str(path.relative_to(folder)): _digest(path) for path in files},
    }
    (folder / ABOUT).write_text(json.dumps(about, indent=1) + "\n")


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
