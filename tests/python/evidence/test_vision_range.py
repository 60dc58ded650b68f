"""The range of vision: marks against the truth, and strangers' trajectories."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cv2")

from command_line import error_line, uwsim
from uwsim.evidence.vision.colmap import Joined
from uwsim.evidence.vision.folder import keep, scored
from uwsim.evidence.vision.judges import Judged, judged
from uwsim.evidence.vision.sequence import ORBIT_HEIGHT_M, ORBIT_M, Condition, orbit, shots
from uwsim.evidence.vision.suite import ALL, KINDS, Row, write


def test_even_light_over_a_reef_is_followed_and_murk_is_not() -> None:
    even = judged(list(shots("reef", Condition("overcast", without=("caustics", "shafts", "shadows")), 3, 8)))
    murky = judged(list(shots("reef", Condition("murky", jerlov="5C"), 3, 4)))
    assert even.complete == 1 and even.drift < 0.15 and even.tracks > 0.9 and even.stereo > 0.3
    assert murky.complete < 0.5 and murky.tracks < 0.3
    row = Row("x", {ALL: murky, "turbidity": even})
    assert row.gained("turbidity", "tracks") == pytest.approx(even.tracks - murky.tracks)
    assert row.gained("turbidity", "drift") == pytest.approx(murky.drift - even.drift)


def test_an_orbit_looks_at_one_place_from_a_circle() -> None:
    plain = Condition("plain", without=("caustics", "shafts", "shadows", "backscatter", "particles"))
    poses = [np.asarray(frame.world_from_optical) for frame in orbit("lake", plain, 1, 3)]
    apart_m = [np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(poses, poses[1:] + poses[:1], strict=True)]
    assert apart_m == pytest.approx([apart_m[0]] * 3, abs=1e-3)
    assert 5.0 < apart_m[0] < np.sqrt(3) * ORBIT_M  # the camera is ahead of the middle of its vehicle
    ends = np.array([pose[:3, 3] + np.hypot(ORBIT_M, ORBIT_HEIGHT_M) * pose[:3, 2] for pose in poses])
    assert np.ptp(ends, axis=0).max() < 1.0


def test_the_page_has_what_colmap_joins(tmp_path: Path) -> None:
    marks = dict.fromkeys((ALL, *KINDS), Judged(1.0, 1.0, 1.0, 0.0))
    models = {ALL: Joined(0.02, None), **dict.fromkeys(KINDS, Joined(1.0, 0.0004))}
    pages = [write(tmp_path, [Row("sun", marks, joined)], "reef", [1], 3)[1].read_text() for joined in ({}, models)]
    assert "COLMAP" not in pages[0] and "| sun | 0.02, lost | 1.00, 0.04% |" in pages[1]


def test_a_trajectory_of_another_scale_and_frame_is_judged_by_its_shape(tmp_path: Path) -> None:
    keep(tmp_path / "sun" / "1", list(shots("reef", Condition("sun"), 1, 4)))
    truth = np.loadtxt((tmp_path / "sun" / "1" / "truth.txt").read_text().splitlines(), comments="#")
    assert len(truth) == 4 and len(list((tmp_path / "sun" / "1" / "left").iterdir())) == 4
    way_m = np.linalg.norm(truth[-1, 1:4] - truth[0, 1:4])
    turned = 0.3 * truth[:, [2, 1, 3]] * [1, -1, 1]
    lines = [
        " ".join(f"{value:.6f}" for value in (t, *place, 0, 0, 0, 1))
        for t, place in zip(truth[:, 0], turned, strict=True)
    ]
    (tmp_path / "sun" / "1" / "estimated.txt").write_text("\n".join(lines))
    (exact,) = scored(tmp_path)
    assert exact.complete == 1 and exact.rms_m < 1e-4 * way_m
    lines[-1] = "0.600000 9 9 9 0 0 0 1"
    (tmp_path / "sun" / "1" / "estimated.txt").write_text("\n".join(lines))
    assert scored(tmp_path)[0].rms_m > 0.05 * way_m
    (tmp_path / "sun" / "1" / "estimated.txt").write_text("0 1 2\n")
    refused = uwsim("range", "vision", "--score", str(tmp_path))
    assert refused.returncode == 1
    assert "estimated.txt:1: '0 1 2': must be time_s x y z qx qy qz qw" in error_line(refused)
