"""Colours of a model's points in its pictures: linear light, over the same patch of the bed at every distance."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.evidence.photos.placement import Placement
from uwsim.evidence.photos.reconstruction import Floats, Reconstruction
from uwsim.evidence.photos.water import Sightings

FORMATS = ("JPEG", "PNG", "TIFF", "BMP", "WEBP")
PIXELS_MAX = 200_000_000
SIGHTINGS_MAX, PICTURES_MAX = 60_000, 400
"""Points that are seen from the most different distances are used, until there are so many."""
SIGMAS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
"""Widths of a patch [pixels]; the first is that of a point's farthest sighting."""
DARKEST, BRIGHTEST = 1.0 / 255.0, 0.95
"""Linear light that is used: a pixel that is darker is mostly rounding, a brighter one may be saturated."""


@dataclass(frozen=True)
class Colours:
    """notes: a line for each that was left out."""

    sightings: Sightings | None
    notes: list[str]


def pictures_beside(model: Reconstruction, stated: Path | None) -> Path | None:
    """Return the folder that has a model's pictures: the one stated, or one beside or above the model's."""
    if stated is not None:
        return stated
    above = [model.path, *model.path.resolve().parents[:3]]
    folders = [folder / sub for folder in above for sub in ("images", "")]
    return next((each for each in folders if _inside(each, model.pictures[0]) is not None), None)


def _inside(folder: Path, name: str) -> Path | None:
    """Return a picture's path, unless there is none, or its name leads out of the folder."""
    try:
        path = (folder / name).resolve()
        return path if path.is_file() and path.is_relative_to(folder.resolve()) else None
    except (OSError, ValueError):
        return None


def read_colours(model: Reconstruction, placement: Placement, folder: Path) -> Colours:
    """Return what the pictures in a folder show of a model's points. Nothing in a picture raises an error."""
    ways = placement.turned(model.points[model.seen_point] - model.centres[model.seen_in])
    r_m = np.linalg.norm(ways, axis=1)
    heights = placement.turned(model.centres)[model.seen_in, 2]
    ahead = placement.turned(model.turns[:, :, 2]) / placement.scale
    cosines = np.einsum("ij,ij->i", ways, ahead[model.seen_in]) / r_m
    farthest = np.zeros(len(model.points))
    np.maximum.at(farthest, model.seen_point, r_m)
    chosen = _most_spread(model, r_m)
    light = np.full((len(r_m), 3), np.nan)
    lost: dict[str, list[str]] = {}
    for k in np.unique(model.seen_in[chosen]):
        name, size = model.pictures[k], (int(model.sizes[k, 0]), int(model.sizes[k, 1]))
        picture = _linear(_inside(folder, name), size)
        if isinstance(picture, str):
            lost.setdefault(picture, []).append(name)
            continue
        own = np.flatnonzero(chosen & (model.seen_in == k))
        light[own] = _patches(picture, model.seen_at[own], farthest[model.seen_point[own]] / r_m[own])
    notes = [f"left out: {len(names)} pictures, such as '{names[0]}': {why}" for why, names in lost.items()]
    kept = (np.nan_to_num(light) > DARKEST).all(axis=1) & (np.nan_to_num(light) < BRIGHTEST).all(axis=1)
    for _ in range(2):  # a point or picture with one sighting has no say
        kept &= (np.bincount(model.seen_point[kept], minlength=len(model.points)) > 1)[model.seen_point]
    if not kept.any():
        return Colours(None, notes)
    _, picture_of = np.unique(model.seen_in[kept], return_inverse=True)
    _, point_of = np.unique(model.seen_point[kept], return_inverse=True)
    return Colours(Sightings(light[kept], ways[kept], heights[kept], cosines[kept], picture_of, point_of), notes)


def _most_spread(model: Reconstruction, r_m: Floats) -> NDArray[np.bool_]:
    """Return which observations to use: those of points whose distances differ most, of pictures at even steps."""
    step = -(-len(model.pictures) // PICTURES_MAX)
    usable = model.seen_in % step == 0
    n = len(model.points)
    count = np.maximum(np.bincount(model.seen_point[usable], minlength=n), 1)
    mean = np.bincount(model.seen_point[usable], r_m[usable], n) / count
    spread = np.bincount(model.seen_point[usable], (r_m - mean[model.seen_point])[usable] ** 2, n)
    order = np.argsort(-spread, kind="stable")
    wanted = np.zeros(n, bool)
    wanted[order[: int(np.searchsorted(np.cumsum(count[order]), SIGHTINGS_MAX)) + 1]] = True
    return np.asarray(usable & wanted[model.seen_point])


def _linear(path: Path | None, size: tuple[int, int]) -> Floats | str:
    """Return a picture as linear light (h, w, 3), or why it is not used."""
    from PIL import Image

    if path is None:
        return "there is no such file in the folder"
    try:
        with Image.open(path, formats=FORMATS) as image:
            if image.size != size:
                return f"{image.width} x {image.height} pixels, but its camera has {size[0]} x {size[1]}"
            if image.width * image.height > PIXELS_MAX:
                return f"more than {PIXELS_MAX} pixels"
            if image.mode not in ("RGB", "RGBA"):
                return f"its mode is {image.mode}: must be 8 bits of red, green and blue"
            encoded = np.asarray(image)[:, :, :3]
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        return f"not a readable picture: {' '.join(str(error).split())[:80]}"
    levels = np.arange(256) / 255.0
    table = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    return np.asarray(table[encoded])


def _patches(picture: Floats, at: Floats, nearer: Floats) -> Floats:
    """Return the mean light about places (n, 2), by a Gaussian whose width is SIGMAS[0] times `nearer` (n,).

    A patch is thus as wide on the bed in each sighting: features are brighter or darker than what surrounds them, and
    a patch that grew with the distance would lose that contrast, as by attenuation.
    """
    from scipy.ndimage import gaussian_filter, map_coordinates

    levels = np.interp(np.log(SIGMAS[0] * nearer), np.log(SIGMAS), np.arange(len(SIGMAS)))
    places = [at[:, 1] - 0.5, at[:, 0] - 0.5]
    found = np.zeros((len(at), 3))
    for k, sigma in enumerate(SIGMAS):
        share = np.maximum(0.0, 1.0 - np.abs(levels - k))
        own = share > 0.0
        if own.any():
            for band in range(3):
                blurred = gaussian_filter(picture[:, :, band], sigma, mode="nearest")
                some = map_coordinates(blurred, [each[own] for each in places], order=1, mode="nearest")
                found[own, band] += share[own] * some
    return found
