"""make_dataset: writes labelled pictures at random poses or along a track; `uwsim dataset` calls it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.base.folder_lock import alone_in
from uwsim.base.own_files import is_own
from uwsim.campaigns.datasets.frame import FrameJob, folders, make_frame
from uwsim.campaigns.datasets.spec import DatasetSpec
from uwsim.campaigns.datasets.studio import Studio, digest_of, require_effects, studio_of
from uwsim.campaigns.datasets.tables import split_of_frames, write_tables
from uwsim.campaigns.datasets.track import Track, read_track, track_of
from uwsim.campaigns.workers import Campaign, Ledger
from uwsim.flight.folder import made_folder
from uwsim.scenario import AnyScenario, load
from uwsim.scenario.dump import text_values
from uwsim.scenario.fingerprint import build_fingerprint
from uwsim.scenario.read.validated import validated


@dataclass(frozen=True, eq=False)
class Dataset:
    """A dataset, complete or in progress.

    finished: how many of the n frames exist. files: the tables that cover all frames, written once all frames exist.
    made: number of frames rendered by this call, in wall_s seconds.
    """

    spec: DatasetSpec
    out: Path
    finished: int
    files: tuple[Path, ...]
    made: int
    wall_s: float

    def __repr__(self) -> str:
        rate = f", {self.frames_per_s:.1f} frames/s" if self.made else ""
        return f"<Dataset '{self.out}': {self.finished:,} of {self.spec.n:,} frames of {self.spec.scenario_name}{rate}>"

    @property
    def interrupted(self) -> bool:
        """True if frames are missing; `resume=True` renders them."""
        return self.finished < self.spec.n

    @property
    def frames_per_s(self) -> float:
        """The number of frames rendered per second of wall time."""
        return self.made / self.wall_s if self.wall_s > 0.0 else 0.0


def make_dataset(
    scenario: AnyScenario,
    out: str | Path,
    n: int,
    *,
    along: str | Path | None = None,
    mission: str | Path | None = None,
    **options: Any,
) -> Dataset:
    """Write n labelled frames of a scenario into the folder `out`; the bytes do not depend on the workers.

        uwsim.make_dataset("lake", "data", 1000, size=(320, 240), look_at=("gate", "pipeline"), workers=2)

    scenario: as for Simulator: also a Scenario, or a scenario's content. Poses are random, or evenly spaced along a
    track: either `along`, a file (see datasets.track.read_track), or the track of `mission`, a file that is flown
    first. workers: number of processes on this machine (default: one per core); 0 renders in this process. scheduler:
    the address of a Dask cluster to use instead; its workers must see `out` under the same path. resume: render the
    frames that are missing in `out`, which must have been begun with the same options, scenario and build. options:
    these, the others of uwsim.campaigns.workers.Campaign, and the fields of datasets.spec.DatasetSpec.

    A program that calls this must do so under `if __name__ == "__main__":`, unless workers=0, since the workers import
    the program. Raises ValueError before anything is written, or if no pose is possible for a frame; also OSError.
    """
    source: str | dict[str, Any]
    if isinstance(scenario, str | Path):
        source = str(Path(scenario).resolve()) if Path(scenario).is_file() else str(scenario)
    else:
        source = text_values(load(scenario))
    campaign, fields = Campaign.of(options)
    spec = validated(DatasetSpec, {"scenario": source, "n": n, **fields})
    require_effects(spec)
    threads, show = campaign.job_threads, campaign.show
    with show("checking"):
        digest = digest_of(spec)
        studio = studio_of(spec, threads, digest)
        track = _track(spec, studio, along, mission)
        if track is None:
            studio.vary(0)
            studio.viewpoint(0)  # raises ValueError if there is none
    into = made_folder(Path(out))
    with alone_in(into):
        if not campaign.options.resume:
            _require_no_pictures(into, spec)
        plan = _plan(spec, digest, track)
        with Ledger.opened(into, plan, resume=campaign.options.resume, what="dataset", jobs="frames") as ledger:
            _make_folders(into, spec)
            place = str(into.resolve())
            jobs = {k: FrameJob(spec, digest, k, place, _pose(track, k), threads) for k in range(spec.n)}
            made = campaign.run(ledger, make_frame, jobs)
        files: tuple[Path, ...] = ()
        if len(ledger.results) == spec.n:
            with show("writing tables"):
                splits = split_of_frames(spec.n, spec.val_share, studio.sim.seed, in_sequence=track is not None)
                records = [ledger.results[number] for number in range(spec.n)]
                files = tuple(write_tables(into, studio, plan, records, splits))
        return Dataset(spec, into, len(ledger.results), files, made, campaign.wall_s)


def _track(spec: DatasetSpec, studio: Studio, along: str | Path | None, mission: str | Path | None) -> Track | None:
    """Return n poses on the track, or None without one. Raises ValueError for options that a track makes useless."""
    if along is None and mission is None:
        return None
    if along is not None and mission is not None:
        raise ValueError("along, mission: only one of them can be given")
    for name in (
        "look_at", "distance_m", "clearance_m", "pitch_max_deg", "roll_max_deg", "empty_share", "crowded_share",
    ):  # fmt: skip
        if name in spec.model_fields_set:
            raise ValueError(f"{name}: has no effect along a track, whose poses are fixed")
    if along is not None:
        return read_track(along).spread(spec.n)
    from uwsim.flight.fly import fly  # many imports, which random poses do not need

    assert mission is not None
    name = studio.vehicle.name
    flown = fly(mission, spec.scenario, vehicles=(name,), seed=spec.seed, autosave_s=0.0)
    return track_of(flown.samples[name]).spread(spec.n)


def _pose(track: Track | None, number: int) -> tuple[float, ...] | None:
    if track is None:
        return None
    position, orientation = track.positions_m[number], track.orientations_xyzw[number]
    return (float(track.times_s[number]), *position.tolist(), *orientation.tolist())


def _require_no_pictures(into: Path, spec: DatasetSpec) -> None:
    if not Ledger(into).exists and any(any((into / folder).glob("*")) for folder in _folder_names(spec)):
        raise ValueError(f"--out {into}: holds pictures already, of no dataset that is known: choose another")


def _make_folders(into: Path, spec: DatasetSpec) -> None:
    """Create the folders for the files, and remove files left unfinished by a killed process."""
    for name in _folder_names(spec):
        (into / name).mkdir(exist_ok=True)
        for left_over in (into / name).glob(".[0-9]*"):
            if is_own(left_over):
                left_over.unlink()


def _folder_names(spec: DatasetSpec) -> list[str]:
    return [where.split("/")[0] for where in folders(spec).values()]


def _plan(spec: DatasetSpec, digest: str, track: Track | None) -> dict[str, Any]:
    """Return everything that determines the contents of the files."""
    poses = None
    if track is not None:
        arrays = (track.times_s, track.positions_m, track.orientations_xyzw)
        poses = hashlib.blake2b(b"".join(array.tobytes() for array in arrays), digest_size=8).hexdigest()
    return {
        "options": spec.model_dump(mode="json", exclude={"scenario"}),
        "track": poses,
        "scenario_digest": digest,
        "build": build_fingerprint(),
    }
