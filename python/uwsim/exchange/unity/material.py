"""The colour of a Unity material: its own, times the mean of its picture."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from uwsim.exchange.unity.project import Project

COLOURS, PICTURES = ("_BaseColor", "_Color"), ("_BaseColorMap", "_MainTex")
"""Fields of the shaders of Unity's render pipelines, the newer ones first."""
SIDE = 64  # of the picture whose mean is taken


class Material(NamedTuple):
    """colour: (3,), sRGB from 0 to 1. has_picture: whether a picture's mean is part of it."""

    colour: NDArray[np.float64]
    has_picture: bool


def read_material(project: Project, guid: str) -> Material | None:
    """Return a material file's content; None if the checkout has none that can be read."""
    file = project.path(guid)
    if file is None or file.suffix != ".mat" or not file.is_file():
        return None
    try:
        (material,) = (each.values for each in project.documents(file).values() if each.kind == "Material")
        saved = material["m_SavedProperties"]
        colours, pictures = (
            {k: v for each in saved[key] for k, v in each.items()} for key in ("m_Colors", "m_TexEnvs")
        )
        name = next(name for name in COLOURS if name in colours)
        colour = np.array([float(colours[name][band]) for band in "rgb"])
        picture = next((pictures[name]["m_Texture"].get("guid") for name in PICTURES if name in pictures), None)
    except (ValueError, LookupError, TypeError, AttributeError, StopIteration, OSError):
        return None
    mean = None if picture is None else _mean(project, picture)
    return Material(np.clip(colour if mean is None else colour * mean, 0.0, 1.0), mean is not None)


def _mean(project: Project, guid: str) -> NDArray[np.float64] | None:
    """Return the mean colour (3,) of a picture; None if it cannot be read."""
    file = project.path(guid)
    if file is None or not file.is_file():
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's, about a large picture
            with Image.open(file) as picture:
                pixels = np.asarray(picture.convert("RGB").resize((SIDE, SIDE)), np.float64)
    except Exception:  # Pillow raises errors of any type for malformed files
        return None
    return np.asarray(pixels.mean(axis=(0, 1)) / 255.0)
