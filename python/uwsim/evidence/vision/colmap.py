"""COLMAP as a judge, where pycolmap is installed: how much of an orbit it joins, and the error of the path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from uwsim.evidence.vision.folder import laid_on
from uwsim.instruments.cameras import Frame

Floats = NDArray[np.float64]
LEAST = 3
"""The fewest places that a similarity is fitted to."""


@dataclass(frozen=True)
class Joined:
    """A model of an orbit. registered: share of its pictures.

    path: rms error after a similarity, as a share of the way of those pictures; None where fewer than three are.
    """

    registered: float
    path: float | None


def is_installed() -> bool:
    """Return True if pycolmap is there."""
    return find_spec("pycolmap") is not None


def joined(frames: Mapping[str, Frame]) -> Joined:
    """Judge the pictures of an orbit, in the order of their names."""
    with TemporaryDirectory() as folder:
        centres = build(Path(folder), frames)
    found = sorted(centres)
    if len(found) < LEAST:
        return Joined(len(found) / len(frames), None)
    true = np.array([frames[name].world_from_optical[:3, 3] for name in found], np.float64)
    error_m = np.linalg.norm(laid_on(np.array([centres[name] for name in found]), true) - true, axis=1)
    way_m = float(np.linalg.norm(np.diff(true, axis=0), axis=1).sum())
    return Joined(len(found) / len(frames), float(np.sqrt((error_m**2).mean())) / way_m)


def build(folder: Path, frames: Mapping[str, Frame]) -> dict[str, Floats]:
    """Let COLMAP build a model from pictures and their calibration, and return its cameras' centres (3,) by name.

    The pictures, all of one camera without distortion, are written into the folder, and the models to `sparse` in it;
    the largest is returned, in a frame and scale of its own. One thread, on the processor.
    """
    colmap = import_module("pycolmap")
    colmap.logging.minloglevel = 2  # errors only
    for name, frame in frames.items():
        frame.save(folder / name)
    k = next(iter(frames.values())).info.k
    reader, database, sparse = colmap.ImageReaderOptions(), folder / "matches.db", folder / "sparse"
    reader.camera_model = "PINHOLE"
    reader.camera_params = f"{k[0, 0]},{k[1, 1]},{k[0, 2] + 0.5},{k[1, 2] + 0.5}"
    finder, matcher = colmap.FeatureExtractionOptions(), colmap.FeatureMatchingOptions()
    mapper = colmap.IncrementalPipelineOptions()
    finder.num_threads = matcher.num_threads = mapper.num_threads = 1
    finder.use_gpu = matcher.use_gpu = False
    mapper.ba_refine_focal_length = mapper.ba_refine_extra_params = False
    single = colmap.CameraMode.SINGLE
    colmap.extract_features(
        str(database), str(folder), camera_mode=single, reader_options=reader, extraction_options=finder
    )
    colmap.match_exhaustive(str(database), matching_options=matcher)
    sparse.mkdir()
    models = colmap.incremental_mapping(str(database), str(folder), str(sparse), mapper).values()
    largest = max(models, key=lambda model: model.num_reg_images(), default=None)
    if largest is None:
        return {}
    placed = (largest.images[number] for number in largest.reg_image_ids())
    return {image.name: np.asarray(image.projection_center(), np.float64) for image in placed}
