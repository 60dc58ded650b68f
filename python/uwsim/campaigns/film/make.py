"""make_film: films a recorded run, or flies a mission and films it; `uwsim recording film` calls it."""

from __future__ import annotations

import hashlib
import io
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from uwsim.base.atomic_file import write_atomically
from uwsim.base.ffmpeg import encoder_path
from uwsim.base.folder_lock import alone_in
from uwsim.base.own_files import is_own, remove_own, require_own
from uwsim.campaigns.workers import Campaign, Ledger
from uwsim.figures.reel import Reel
from uwsim.flight.folder import made_folder
from uwsim.recording.filming.options import FilmOptions
from uwsim.recording.filming.roll import Roll
from uwsim.recording.filming.shot import Shot, shoot
from uwsim.recording.filming.shots import shots_of
from uwsim.scenario.fingerprint import build_fingerprint

SUFFIXES = (".mp4", ".webp")
RUN = "run.mcap"


@dataclass(frozen=True, eq=False)
class Film:
    """A film, complete or in progress. finished: how many of the frames exist. made: those rendered by this call."""

    out: Path
    frames: int
    finished: int
    made: int

    @property
    def interrupted(self) -> bool:
        """True if frames are missing; `resume=True` renders them."""
        return self.finished < self.frames


def make_film(
    source: str | Path,
    out: str | Path = "film.mp4",
    *,
    scenario: str = "lake",
    **options: Any,
) -> Film:
    """Film a run; the bytes of the frames do not depend on the workers.

        uwsim.campaigns.film.make_film("reef", "dive.mp4", from_s=60, until_s=72)

    source: a recording (.mcap), a mission's file (.py), which is flown in `scenario`, or a scenario, whose survey is
    flown. out: .mp4 (needs ffmpeg) or .webp; the frames are kept beside it, in a folder that ends in .frames. options:
    those of FilmOptions; workers, scheduler and resume, as for make_dataset, and the others of
    uwsim.campaigns.workers.Campaign. Raises ValueError before anything is written, or if the run cannot be repeated;
    OSError.
    """
    campaign, others = Campaign.of(options)
    wanted = FilmOptions(**others)
    resume, show, size, fps = campaign.options.resume, campaign.show, wanted.pixels, wanted.fps
    target = Path(out)
    folder = target.with_suffix(".frames")
    encode = _encoder(target, size, fps)
    if Ledger(folder).exists != resume:
        rule = "holds no film to resume" if resume else "holds a film already: --resume, or another --out"
        raise ValueError(f"'{folder}': {rule}")
    for path in (source, wanted.camera):
        if Path(path).suffix in (".mcap", ".csv") and not Path(path).is_file():
            raise FileNotFoundError(f"'{path}': no such file")
    is_new = not folder.exists()
    try:
        with alone_in(made_folder(folder)):
            with show("flying"):
                recording = _recorded(source, folder, scenario, wanted.until_s + 1 / fps, resume=resume)
            with show("repeating the run"):
                shots = shots_of(recording, Roll.of(recording, wanted), folder, wanted, campaign.job_threads)
            if not resume:
                for shot in shots:
                    require_own(Path(shot.path))
            plan = {
                "flight": _flight(source, scenario, wanted.until_s), "size": list(size), "fps": fps,
                "quality": wanted.quality, "camera": wanted.camera, "run": _digest(shots), "build": build_fingerprint(),
            }  # fmt: skip
            with Ledger.opened(folder, plan, resume=resume, what="film", jobs="frames") as ledger:
                frames = dict(enumerate(shots))
                made = campaign.run(ledger, shoot, frames, lacks=lambda k: not Path(shots[k].path).exists())
    finally:
        if is_new and folder.exists() and not Ledger(folder).exists:
            remove_own(folder)  # no frame was begun
    found = Film(target, len(shots), len(ledger.results), made)
    if not found.interrupted:
        with show("encoding"):
            encode([Path(shot.path) for shot in shots])
    return found


def _recorded(source: str | Path, folder: Path, scenario: str, until_s: float, *, resume: bool) -> Path:
    """Return the recording to film: the source itself, or that of its flight. Raises ValueError or OSError."""
    if Path(source).suffix == ".mcap":
        return Path(source)
    run = folder / RUN
    if not (resume and run.exists()):
        if is_own(run):
            run.unlink()  # of a flight that was broken off
        from uwsim.flight.fly import fly  # many imports

        mission, where = (source, scenario) if Path(source).suffix == ".py" else (None, source)
        flown = fly(
            mission, where, time_limit_s=until_s, record=run, sample_sensors=False, report="none", autosave_s=0.0
        )
        if flown.interrupted:
            run.unlink(missing_ok=True)  # half a flight, which --resume would film
            raise KeyboardInterrupt  # which the flight caught
    return run


def _flight(source: str | Path, scenario: str, until_s: float) -> str | None:
    """Return the name of the flight made for a film, for its plan; None for a recording. Raises OSError."""
    if Path(source).suffix == ".mcap":
        return None
    if Path(source).suffix == ".py":
        mission = hashlib.blake2b(Path(source).read_bytes(), digest_size=8).hexdigest()
        return f"{Path(source).name} ({mission}) in {scenario} until {until_s:g} s"
    return f"the survey of {source} until {until_s:g} s"


def _digest(shots: list[Shot]) -> str:
    """Return a fingerprint of everything that the frames depend on besides the plan's other keys."""
    digest = hashlib.blake2b(digest_size=8)
    for shot in shots:
        state = shot.states[0]
        parts = [np.array([state.time_ns, shot.gain, len(state.lamps)]), state.positions_m, state.orientations_xyzw]
        digest.update(b"".join(np.asarray(part, np.float64).tobytes() for part in (*parts, shot.poses)))
        digest.update(state.optics.model_dump_json().encode() + shot.mount.model_dump_json().encode())
    return digest.hexdigest()


def _encoder(out: Path, size: tuple[int, int], fps: float) -> Callable[[list[Path]], None]:
    """Return the function that writes the file, once it is certain that it can. Raises ValueError or OSError."""
    if out.suffix not in SUFFIXES:
        raise ValueError(f"--out {out}: must end in {' or '.join(SUFFIXES)}")
    require_own(out)
    if out.is_dir():
        raise IsADirectoryError(f"--out {out}: is a folder")
    if out.suffix == ".webp":
        return lambda frames: _write_webp(out, frames, fps)
    if size[0] % 2 or size[1] % 2:
        raise ValueError(f"--size {size[0]}x{size[1]}: both must be even for .mp4")
    program = encoder_path("uwsim recording film")
    return lambda frames: _write_mp4(program, out, frames, fps)


def _write_webp(out: Path, frames: list[Path], fps: float) -> None:
    ends_ms = [round(1000 * k / fps) for k in range(len(frames) + 1)]
    reel = Reel(len(frames), lambda number: Image.open(io.BytesIO(frames[number].read_bytes())))
    write_atomically(out, reel.encoded("webp", np.diff(ends_ms).tolist(), quality=60, method=4))


def _write_mp4(program: str, out: Path, frames: list[Path], fps: float) -> None:
    with tempfile.TemporaryDirectory() as folder:
        coded = Path(folder) / "film.mp4"
        command = [program, "-loglevel", "error", "-framerate", f"{fps:g}", "-i", "%06d.png"]
        command += ["-frames:v", str(len(frames))]
        command += [
            "-c:v",
            "libx264",
            "-preset",
            "slow",
            "-crf",
            "18",
            "-pix_fmt",
            "yuv420p",
            "-movflags",
            "+faststart",
        ]
        done = subprocess.run([*command, str(coded)], cwd=frames[0].parent, capture_output=True, check=False)
        if done.returncode:
            raise OSError(f"'{out}': ffmpeg: {done.stderr[-200:].decode(errors='replace').strip()}")
        write_atomically(out, coded.read_bytes())
