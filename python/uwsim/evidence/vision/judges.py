"""Marks of pictures as a camera's program uses them: tracks that stay, stereo matches, and odometry, all by OpenCV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from uwsim.evidence.vision.sequence import BASELINE_M, Shot
from uwsim.instruments.cameras import Frame

Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]
NEAR_PX, STEREO_ERROR = 1.0, 0.05
FEATURES, LEAST = 1200, 12
"""ORB's features per picture; the matches that must agree with a pose."""


@dataclass(frozen=True)
class Judged:
    """A sequence's marks. All but drift are shares in [0, 1], of which 1 is best.

    tracks: corners (Shi and Tomasi 1994) that Lucas and Kanade's tracker finds within 1 pixel of their true place in
    the next picture. stereo: ORB features (Rublee et al. 2011) of the left picture whose match in the right one gives
    their depth within 5 %. complete: pairs of pictures whose motion is found. drift: of the position at the end, as a
    share of the way, where lost pairs count with the true motion.
    """

    tracks: float
    stereo: float
    complete: float
    drift: float


def judged(shots: Sequence[Shot]) -> Judged:
    """Judge a sequence of at least two stereo pictures."""
    orb = cv2.ORB.create(nfeatures=FEATURES, fastThreshold=7)
    kept = corners = right_depths = features = solved = 0
    pose = first = _pose(shots[0].left)
    way_m = 0.0
    for now, then in pairwise(shots):
        more, of = _tracked(now.left, then.left)
        kept, corners = kept + more, corners + of
        good, of, points, words = _stereo(orb, now)
        right_depths, features = right_depths + good, features + of
        motion = _motion(orb, points, words, then.left)
        truth = np.linalg.inv(_pose(now.left)) @ _pose(then.left)
        solved += motion is not None
        pose = pose @ (truth if motion is None else motion)
        way_m += float(np.linalg.norm(truth[:3, 3]))
    end = _pose(shots[-1].left)
    drift_m = float(np.linalg.norm((np.linalg.inv(first) @ pose - np.linalg.inv(first) @ end)[:3, 3]))
    pairs = len(shots) - 1
    return Judged(kept / max(corners, 1), right_depths / max(features, 1), solved / pairs, drift_m / way_m)


def _pose(frame: Frame) -> Floats:
    return np.asarray(frame.world_from_optical, np.float64)


def _calibration(frame: Frame) -> tuple[Floats, Floats]:
    return np.asarray(frame.info.k, np.float64).reshape(3, 3), np.asarray(frame.info.d, np.float64)


def _grey(frame: Frame) -> Grey:
    return np.asarray(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY), np.uint8)


def _depths(frame: Frame, pixels: Floats) -> Floats:
    column, row = np.rint(pixels).astype(int).T
    height, width = frame.depth_m.shape
    return np.asarray(frame.depth_m[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)], np.float64)


def _points(frame: Frame, pixels: Floats, depths_m: Floats) -> Floats:
    """Return places (n, 3) in the optical frame."""
    flat = cv2.undistortPoints(pixels[:, None].astype(np.float64), *_calibration(frame)).reshape(-1, 2)
    return np.column_stack([flat * depths_m[:, None], depths_m])


def _seen(frame: Frame, points: Floats) -> Floats:
    k, distortion = _calibration(frame)
    still = np.zeros(3)
    return np.asarray(cv2.projectPoints(np.ascontiguousarray(points), still, still, k, distortion)[0].reshape(-1, 2))


def _tracked(first: Frame, second: Frame) -> tuple[int, int]:
    """Return how many corners stay, and of how many that are still in the picture."""
    one, two = _grey(first), _grey(second)
    found = cv2.goodFeaturesToTrack(one, 200, 0.01, 5)
    if found is None:
        return 0, 0
    corners = np.asarray(found, np.float64).reshape(-1, 2)
    depths_m = _depths(first, corners)
    corners, depths_m = corners[np.isfinite(depths_m)], depths_m[np.isfinite(depths_m)]
    if len(corners) == 0:
        return 0, 0
    between = np.linalg.inv(_pose(second)) @ _pose(first)
    places = _points(first, corners, depths_m) @ between[:3, :3].T + between[:3, 3]
    ahead = places[:, 2] > 0
    true = np.where(ahead[:, None], _seen(second, np.where(ahead[:, None], places, 1.0)), -1.0)
    inside = ((true > 0) & (true < np.array(one.shape[::-1]) - 1)).all(axis=1) & ahead
    flowed, is_found = _flow(one, two, corners, 21)
    near = is_found & (np.linalg.norm(flowed - true, axis=1) < NEAR_PX)
    return int((near & inside).sum()), int(inside.sum())


def _flow(one: Grey, two: Grey, pixels: Floats, window: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Return where Lucas and Kanade's tracker finds pixels (n, 2), and whether it does."""
    start = pixels[:, None].astype(np.float32)
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        one, two, start, start.copy(), winSize=(window, window), flags=cv2.OPTFLOW_USE_INITIAL_FLOW
    )
    return np.asarray(found, np.float64).reshape(-1, 2), np.asarray(status).ravel() == 1


def _features(orb: cv2.ORB, frame: Frame) -> tuple[Floats, NDArray[np.uint8] | None]:
    points, words = orb.detectAndCompute(_grey(frame), None)
    pixels = np.array([point.pt for point in points], np.float64).reshape(-1, 2)
    return pixels, None if words is None else np.asarray(words, np.uint8)


def _matches(one: NDArray[np.uint8] | None, other: NDArray[np.uint8] | None) -> NDArray[np.intp]:
    """Return pairs of indices (n, 2)."""
    if one is None or other is None:
        return np.empty((0, 2), np.intp)
    found = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(one, other)
    return np.array([(each.queryIdx, each.trainIdx) for each in found], np.intp).reshape(-1, 2)


def _stereo(orb: cv2.ORB, shot: Shot) -> tuple[int, int, Floats, NDArray[np.uint8]]:
    """Return how many depths are right, of how many features on something; the places found, and their words.

    Matches are found to a part of a pixel by Lucas and Kanade's method, and must lie on the same row.
    """
    left, words = _features(orb, shot.left)
    if words is None:
        return 0, 0, np.empty((0, 3)), np.empty((0, 32), np.uint8)
    true_m = _depths(shot.left, left)
    found, is_found = _flow(_grey(shot.left), _grey(shot.right), left, 15)
    k, distortion = _calibration(shot.left)
    a, b = (cv2.undistortPoints(np.asarray(each, np.float64).reshape(-1, 1, 2), k, distortion).reshape(-1, 2)
            for each in (left, found))  # fmt: skip
    shift = a[:, 0] - b[:, 0]
    usable = is_found & (np.abs(a[:, 1] - b[:, 1]) < NEAR_PX / k[1, 1]) & (shift > NEAR_PX / k[0, 0])
    depth_m = np.where(usable, BASELINE_M / np.where(usable, shift, 1.0), 0.0)
    good = usable & np.isfinite(true_m) & (np.abs(depth_m - true_m) < STEREO_ERROR * true_m)
    places = np.column_stack([a * depth_m[:, None], depth_m])[usable]
    return int(good.sum()), int(np.isfinite(true_m).sum()), places, words[usable]


def _motion(orb: cv2.ORB, points: Floats, words: NDArray[np.uint8], then: Frame) -> Floats | None:
    """Return the pose (4, 4) of the next left picture in the frame of this one, or None where it is lost."""
    pixels, other = _features(orb, then)
    pairs = _matches(words if len(words) else None, other)
    if len(pairs) < LEAST:
        return None
    solved, turn, shift, agree = cv2.solvePnPRansac(
        points[pairs[:, 0]], pixels[pairs[:, 1]], *_calibration(then), reprojectionError=2.0, iterationsCount=200
    )
    if not solved or agree is None or len(agree) < LEAST:
        return None
    then_from_now = np.eye(4)
    then_from_now[:3, :3], then_from_now[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
    return np.asarray(np.linalg.inv(then_from_now))
