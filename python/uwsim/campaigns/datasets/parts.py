"""Parts of obstacles in pictures: joints, anodes, defects, holes and growth, each with a mask of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.campaigns.datasets.formats.coco import annotation
from uwsim.instruments.cameras import Frame
from uwsim.scenario.build.obstacles import obstacle_parts
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.spec.part import Part, Seen
from uwsim.simulator.simulator import Simulator

FAR_M = 1e4
"""Where rays end that meet nothing."""


class Parts:
    """The parts of a scenario's obstacles, numbered from 1; where they overlap, the larger number counts."""

    def __init__(self, sim: Simulator, class_names: list[str]) -> None:
        """Collect them. class_names: the classes of surfaces, which those of parts follow. Raises ScenarioError."""
        terrain = build_terrain(sim.scenario.terrain)
        self.all: list[tuple[str, Part]] = [
            (obstacle.name, part) for obstacle in sim.scenario.obstacles for part in obstacle_parts(obstacle, terrain)
        ]
        kinds = dict.fromkeys(part.kind for _, part in self.all)
        self.class_names = [*class_names, *(kind for kind in kinds if kind not in class_names)]
        self._label_of = {name: label for label, name in enumerate(sim.world.label_names)}

    def __len__(self) -> int:
        """Return the number of parts."""
        return len(self.all)

    def described(self) -> list[dict[str, Any]]:
        """Return number, class, obstacle and place [m] of each part."""
        return [
            {
                "number": k + 1,
                "name": part.kind,
                "obstacle": obstacle,
                "position_m": None if part.place_m is None else [round(float(x), 4) for x in part.place_m],
            }
            for k, (obstacle, part) in enumerate(self.all)
        ]

    def masks(
        self, frame: Frame, rays: NDArray[np.float32], distances_m: NDArray[np.float32], range_m: float
    ) -> dict[int, NDArray[np.bool_]]:
        """Return the mask (H, W) of each part in a picture, by number.

        rays (H, W, 2): directions at depth 1 in the optical frame. distances_m (H, W): along them. range_m: what is
        farther away is left out.
        """
        seen = _seen(frame, rays, distances_m)
        found = {}
        for k, (obstacle, part) in enumerate(self.all):
            at_m = 0.0 if part.place_m is None else float(np.linalg.norm(part.place_m - seen.eye_m)) - part.radius_m
            if at_m > range_m:
                continue
            is_on = (frame.labels == self._label_of[obstacle]).ravel() & (distances_m.ravel() <= range_m)
            mask = part.mask(seen._replace(is_on=is_on))
            if mask.any():
                found[k + 1] = mask.reshape(distances_m.shape)
        return found

    def annotations(
        self, masks: dict[int, NDArray[np.bool_]], distances_m: NDArray[np.float32], label_names: list[str],
        min_pixels: int,
    ) -> list[dict[str, Any]]:  # fmt: skip
        """Return COCO's annotations of masks that have as many pixels; `part` is the part's number."""
        found = []
        for number, mask in masks.items():
            obstacle, part = self.all[number - 1]
            if int(mask.sum()) >= min_pixels:
                category, label = self.class_names.index(part.kind), label_names.index(obstacle)
                found.append(annotation(mask, category, obstacle, label, distances_m) | {"part": number})
        return found


def drawn(masks: dict[int, NDArray[np.bool_]], shape: tuple[int, int]) -> NDArray[np.uint16]:
    """Return the number of the part that each pixel shows, (H, W), else 0."""
    picture = np.zeros(shape, np.uint16)
    for number, mask in masks.items():
        picture[mask] = number
    return picture


def _seen(frame: Frame, rays: NDArray[np.float32], distances_m: NDArray[np.float32]) -> Seen:
    ways = np.concatenate([rays, np.ones((*rays.shape[:2], 1), np.float32)], axis=-1).reshape(-1, 3).astype(np.float64)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    pose = np.asarray(frame.world_from_optical, np.float64)
    reach_m = np.minimum(distances_m.ravel().astype(np.float64), FAR_M)
    points = (ways * reach_m[:, None]) @ pose[:3, :3].T + pose[:3, 3]
    return Seen(pose[:3, 3], points, np.zeros(len(points), np.bool_))
