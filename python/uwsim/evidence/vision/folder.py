"""A sequence's pictures in a folder for other programs, and marks of the trajectories that they leave there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.atomic_file import write_atomically
from uwsim.base.texts.text_file import require_regular
from uwsim.evidence.vision.sequence import BASELINE_M, RATE_HZ, Shot
from uwsim.instruments.cameras.image_file import write_image
from uwsim.scenario.read.calibration import write_calibration

Floats = NDArray[np.float64]
TRUTH, ESTIMATE = "truth.txt", "estimated.txt"
HEAD = "# time_s x y z qx qy qz qw: the left camera's optical frame in the world, as TUM's RGB-D benchmark has it\n"
NEAR_S = 0.5 / RATE_HZ


@dataclass(frozen=True)
class Scored:
    """A trajectory beside the truth, after a similarity (Umeyama 1991). complete: share of the pictures with a pose."""

    folder: Path
    complete: float
    rms_m: float
    drift: float


def keep(folder: Path, shots: Sequence[Shot]) -> None:
    """Write left/ and right/ pictures, left.yaml, and the true poses of the left camera."""
    lines = []
    for k, shot in enumerate(shots):
        for side, frame in (("left", shot.left), ("right", shot.right)):
            (folder / side).mkdir(parents=True, exist_ok=True)
            write_image(folder / side / f"{k:04d}.png", frame.rgb)
        pose = np.asarray(shot.left.world_from_optical, np.float64)
        turn = Rotation.from_matrix(pose[:3, :3]).as_quat()
        lines.append(" ".join(f"{value:.9g}" for value in (k / RATE_HZ, *pose[:3, 3], *turn)))
    write_calibration(folder / "left.yaml", shots[0].left.info, "left")
    about = f"# right camera: {BASELINE_M} m to the right of the left one, 5 ms later\n"
    write_atomically(folder / TRUTH, (HEAD + about + "\n".join(lines) + "\n").encode())


def scored(folder: Path) -> list[Scored]:
    """Return the marks of each estimated.txt that lies beside a truth.txt. Raises ValueError, OSError."""
    found = []
    for path in sorted(folder.rglob(ESTIMATE)):
        if not (path.parent / TRUTH).exists():
            continue
        truth, estimate = (_trajectory(path.parent / name) for name in (TRUTH, ESTIMATE))
        nearest = np.abs(truth[:, :1] - estimate[:, 0]).argmin(axis=1)
        both = np.abs(truth[:, 0] - estimate[nearest, 0]) < NEAR_S
        if both.sum() < 3:
            raise ValueError(f"{path}: {both.sum()} poses at the times of {TRUTH}: must be at least 3")
        true, own = truth[both, 1:4], estimate[nearest[both], 1:4]
        error_m = np.linalg.norm(laid_on(own, true) - true, axis=1)
        way_m = float(np.linalg.norm(np.diff(true, axis=0), axis=1).sum())
        rms_m = float(np.sqrt((error_m**2).mean()))
        found.append(Scored(path.parent, float(both.mean()), rms_m, float(error_m[-1]) / max(way_m, 1e-9)))
    if not found:
        raise ValueError(f"{folder}: no folder in it has {ESTIMATE} beside {TRUTH}")
    return found


def _trajectory(path: Path) -> Floats:
    """Return rows of time and pose (n, 8). Raises ValueError, OSError."""
    rows = []
    for number, line in enumerate(require_regular(path).read_text(errors="replace").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) != 8 or not np.isfinite(row).all():
            raise ValueError(f"{path}:{number}: {line.strip()[:60]!r}: must be time_s x y z qx qy qz qw")
        rows.append(row)
    if not rows:
        raise ValueError(f"{path}: has no poses")
    return np.array(rows)


def laid_on(points: Floats, target: Floats) -> Floats:
    """Return points (n, 3) moved by the similarity that brings them nearest to the target."""
    a, b = points - points.mean(axis=0), target - target.mean(axis=0)
    u, s, vt = np.linalg.svd(b.T @ a)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = float((s * sign).sum() / max((a**2).sum(), 1e-12))
    return np.asarray(scale * a @ ((u * sign) @ vt).T + target.mean(axis=0))
