"""Models of structure from motion, as a source of scenarios."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.evidence.scenario_source import Made, ScenarioSource


def _accepts(path: Path) -> bool:
    from uwsim.evidence.photos.colmap import models_in

    return path.is_dir() and bool(models_in(path))


def _make(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    from uwsim.evidence.photos.colmap import models_in, read_model
    from uwsim.evidence.photos.world import scenario_from

    first, *others = [read_model(folder) for folder in models_in(path)]
    for k, other in enumerate(others):  # the largest, since COLMAP writes one for each part that does not join
        if len(other.pictures) > len(first.pictures):
            first, others[k] = other, first
    first.notes.extend(f"left out: model '{each.path}', of {len(each.pictures)} pictures" for each in others)
    return scenario_from(first, out, options)


COLMAP = ScenarioSource(
    "a COLMAP model, a folder with cameras, images and points3D",
    _accepts,
    _make,
    ("scale", "positions", "depth", "images", "cell"),
)
