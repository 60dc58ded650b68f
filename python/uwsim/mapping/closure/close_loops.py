"""close_loops: corrects a flight's track so that its submaps match where they overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.closure.matching import Match, match
from uwsim.mapping.closure.pose_graph import drift_std_m, solve, turned
from uwsim.mapping.closure.submaps import Submap, submaps
from uwsim.mapping.closure.track import PingTrack

Array = NDArray[np.float64]
CANDIDATES = 2
LEAST_COMMON = 0.25  # least share of the plan area that a candidate must have in common
GATE = 4.0  # in standard deviations: a match that moves a submap farther is rejected


@dataclass(frozen=True, eq=False)
class ClosedTrack:
    """The corrected track. world_from_body: one (4, 4) per ping. matches: the closed loops.

    corrections: (submaps, 3), x, y [m] and rotation [rad]. tried: number of overlapping pairs of submaps.
    """

    world_from_body: list[Array]
    submaps: list[Submap]
    matches: list[Match]
    corrections: Array
    tried: int


def close_loops(track: PingTrack) -> ClosedTrack:
    """Match the submaps of a flight where they overlap, and correct its track accordingly (Lu and Milios 1997)."""
    maps = submaps(track)
    corrections = np.zeros((len(maps), 3))
    pairs = [(i, j) for j in range(len(maps)) for i in _candidates(maps, j)]
    found = (match(maps, i, j) for i, j in pairs)
    matches = [m for m in found if m is not None and _is_likely(maps, m)]
    if matches:
        corrections = solve(maps, matches)
    return ClosedTrack(_corrected(track, maps, corrections), maps, matches, corrections, len(pairs))


def _candidates(maps: list[Submap], second: int) -> list[int]:
    """Return the earlier submaps that overlap most with `second`, excluding its immediate predecessor."""
    earlier = [i for i in range(second - 1) if maps[i].overlap(maps[second]) >= LEAST_COMMON]
    return sorted(earlier, key=lambda i: maps[i].overlap(maps[second]), reverse=True)[:CANDIDATES]


def _placed(submap: Submap, correction: Array) -> Array:
    """Return the transform (4, 4) that moves a submap to its corrected position."""
    pose = np.eye(4)
    pose[:2, :2] = turned(np.eye(2), correction[2]).T
    pose[:2, 3] = submap.anchor_m + correction[:2] - pose[:2, :2] @ submap.anchor_m
    return pose


def _is_likely(maps: list[Submap], m: Match) -> bool:
    std = np.hypot(drift_std_m(maps, m.first, m.second), np.sqrt(m.covariance.diagonal()[:2].max()))
    return bool(np.linalg.norm(m.here_m - m.there_m) <= GATE * std)


def _corrected(track: PingTrack, maps: list[Submap], corrections: Array) -> list[Array]:
    """Return the corrected poses, interpolated between the centres of adjacent submaps except across a jump."""
    if not maps:
        return list(track.world_from_body)
    middles = np.array([submap.time_s for submap in maps])
    placed = [_placed(submap, correction) for submap, correction in zip(maps, corrections, strict=True)]
    poses = []
    for time_s, pose in zip(track.times_s, track.world_from_body, strict=True):
        after = int(np.clip(np.searchsorted(middles, time_s), 1, max(len(maps) - 1, 1)))
        before, after = after - 1, min(after, len(maps) - 1)
        share = 0.0
        if after > before:
            share = float(np.clip((time_s - middles[before]) / (middles[after] - middles[before]), 0.0, 1.0))
            if maps[after].jump_m.any():
                share = float(time_s >= track.times_s[maps[after].first])
        turn = (1.0 - share) * corrections[before, 2] + share * corrections[after, 2]
        fixed = np.eye(4)
        fixed[:2, :2] = turned(np.eye(2), turn).T
        fixed = fixed @ pose
        fixed[:3, 3] = ((1.0 - share) * placed[before] @ pose + share * placed[after] @ pose)[:3, 3]
        poses.append(fixed)
    return poses
