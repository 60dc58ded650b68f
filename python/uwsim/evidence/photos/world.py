"""Writes a model of structure from motion as a scenario: its bed, and its water by the colours of its pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from affine import Affine

from uwsim import _core
from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.evidence.photos.bed import Bed, read_bed
from uwsim.evidence.photos.placement import Placement, place
from uwsim.evidence.photos.reconstruction import Reconstruction
from uwsim.evidence.robots.robot import plain_name
from uwsim.evidence.robots.written import require_simulable
from uwsim.evidence.scenario_source import Made, NotMadeError
from uwsim.evidence.soundings import geotiff
from uwsim.scenario.dump import yaml_text

DEPTH_M, CLEAR_M = 10.0, 1.0
"""Assumed: the depth of the bed's median. The least depth of its top."""
ALTITUDE_M, SURVEY_SHARE = 3.0, 0.8
BANDS = ("red", "green", "blue")
UNSURE, LOOSE = 0.25, 0.5
"""Half an interval, as a share of c: from UNSURE on, c is given by its interval alone; LOOSE determines too little."""


def scenario_from(model: Reconstruction, out: Path | None, options: Mapping[str, Any]) -> Made:
    """Write the folder `out`: NAME.yaml and bed.tif. options: scale, positions, depth, images and cell.

    Raises ValueError, of NotMadeError with what was read, or OSError.
    """
    model = model.reliable()
    notes = list(model.notes)
    try:
        placement = place(model, scale=options.get("scale"), positions=options.get("positions"))
        notes += placement.notes
        bed = read_bed(model, placement, options.get("cell"))
        notes += bed.notes
        shift_m = _depth(bed, placement, options.get("depth"), notes)
        optics = _optics(model, placement, options.get("images"), notes)
        notes.append("left out: the lens: a camera's key `calibration` takes one")
        notes.append("assumed: the bed scatters sound as sand, and its colour is that of sand")
        name = plain_name(_own_name(model.path) if out is None else out.name)
        values = _values(name, model, bed, shift_m, optics)
        (rows, columns), cell = bed.heights_m.shape, bed.cell_m
        corner = Affine(cell, 0.0, -0.5 * columns * cell, 0.0, -cell, 0.5 * rows * cell)
        contents = {
            "bed.tif": geotiff(bed.heights_m + shift_m, corner, None),
            f"{name}.yaml": yaml_text(values).encode(),
        }
        require_simulable(name, contents)
    except ValueError as error:
        raise NotMadeError(str(error), notes) from None
    folder = out or Path(name)
    for file in contents:
        require_own(folder / file)
    folder.mkdir(parents=True, exist_ok=True)
    for file, content in contents.items():
        write_atomically(folder / file, content)
    return Made(folder / f"{name}.yaml", notes)


def _own_name(folder: Path) -> str:
    """Return the name of the folder that a model is of: that above sparse/0."""
    parts = [part for part in folder.resolve().parts[1:] if not part.isdigit() and part not in ("sparse", "dense")]
    return parts[-1] if parts else "photos"


def _depth(bed: Bed, placement: Placement, depth_m: float | None, notes: list[str]) -> float:
    """Return what is added to the bed's heights, so that the surface is z = 0. Raises ValueError."""
    middle_m, top_m = float(np.median(bed.points_m[:, 2])), float(bed.heights_m.max())
    if placement.has_place and depth_m is None:
        east, north = bed.origin_m
        notes.append(f"the world's origin is ({east:.3f}, {north:.3f}) m of the positions, its surface their height 0")
        shift_m = 0.0
    else:
        shift_m = -middle_m - (depth_m if depth_m is not None else max(DEPTH_M, top_m - middle_m + CLEAR_M))
        if depth_m is None:
            notes.append(f"assumed: the bed's median is {-middle_m - shift_m:g} m deep: --depth states it")
    if top_m + shift_m > -CLEAR_M:
        raise ValueError(
            f"the bed's top is at z = {top_m + shift_m:.2f} m: must lie {CLEAR_M:g} m or more below the "
            "surface: --depth, or heights in --positions from the surface, up"
        )
    return shift_m


def _optics(model: Reconstruction, placement: Placement, images: Path | None, notes: list[str]) -> dict[str, Any]:
    """Return the key `optics` by the pictures' colours, or nothing, with a note of the reason."""
    from uwsim.evidence.photos.colours import pictures_beside, read_colours
    from uwsim.evidence.photos.water import fit_attenuation

    usual = "the water is the scenario's usual, Jerlov III"
    folder = pictures_beside(model, images)
    if folder is None:
        notes.append(f"left out: colours: '{model.pictures[0]}' is not beside or above the model (--images); {usual}")
        return {}
    colours = read_colours(model, placement, folder)
    notes += colours.notes
    if colours.sightings is None:
        notes.append(f"left out: colours: no picture in '{folder}' can be used; {usual}")
        return {}
    found = fit_attenuation(colours.sightings)
    each = ", ".join(attenuation_text(*of) for of in zip(BANDS, found.c, found.half, strict=True))
    notes.append(
        f"read: '{folder}': attenuation c [1/m] {each} (95 %), of {found.count} pixels, whose scatter is "
        f"{100.0 * found.scatter:.0f} %; assumed: daylight alone, and one white balance"
    )
    if found.alike:
        others = [name for name in found.alike if name != found.jerlov]
        also = f"; {', '.join(others)} would fit, too" if others else ""
        notes.append(f"water: Jerlov {found.jerlov}, whose c is {_three(found.type_c)} 1/m, within that{also}")
        return {"optics": {"jerlov": found.jerlov}}
    if not (np.isfinite(found.half) & (found.half < LOOSE * found.c)).all():
        notes.append(f"left out: attenuation: an interval exceeds {100.0 * LOOSE:g} % of its value; {usual}")
        return {}
    water, ratio = _core.WaterOptics.jerlov(found.jerlov), found.c / found.type_c
    nearest = f"Jerlov {found.jerlov}, the nearest type, whose c is {_three(found.type_c)} 1/m"
    notes.append(f"assumed: shares of absorption, scattering and Kd as in {nearest}")
    keys = ("diffuse_attenuation", "absorption", "scattering")
    coefficients = {key: [float(f"{v:.4g}") for v in np.asarray(getattr(water, key)) * ratio] for key in keys}
    return {"optics": {"coefficients": coefficients}}


def attenuation_text(band: str, c: float, half: float) -> str:
    """Return a band's c [1/m] with half of its interval, or the interval alone where c is badly determined."""
    if half <= UNSURE * c:
        return f"{band} {c:.3f} +- {half:.3f}"
    if not np.isfinite(half):
        return f"{band} not determined"
    return f"{band} badly determined, {max(c - half, 0.0):.3f} to {c + half:.3f}"


def _three(values: Any) -> str:
    return ", ".join(f"{value:.3f}" for value in values)


def _values(name: str, model: Reconstruction, bed: Bed, shift_m: float, optics: dict[str, Any]) -> dict[str, Any]:
    size_m = [float(f"{bed.cell_m * (count - 1):.9g}") for count in bed.heights_m.shape[::-1]]
    top_m, deep_m = float(bed.heights_m.max()) + shift_m, float(bed.heights_m.min()) + shift_m
    altitude_m = round(min(ALTITUDE_M, -0.5 * top_m), 2)
    x, y = (round(float(each), 2) for each in SURVEY_SHARE * bed.half_m)
    return {
        "name": name,
        "description": f"the bed in {len(model.pictures)} pictures, {-top_m:.1f} to {-deep_m:.1f} m deep",
        "mission_time_s": 3600,
        **optics,
        "terrain": {
            "source": "raster",
            "file": "bed.tif",
            "crs": "local",
            "water_level_m": 0.0,
            "centre": [0.0, 0.0],
            "size_m": size_m,
            "spacing_m": bed.cell_m,
            "interpolation": "linear",
        },
        "vehicles": [
            {
                "name": "rov",
                "model": "bluerov2_heavy_outfit",
                "start": {"position_m": [-x, -y, round(min(-0.5, top_m + 0.5 * altitude_m), 2)]},
                "sonar": {"model": 2, "tilt_deg": 90},
            }
        ],
        "survey": {
            "area_m": [[-x, -y], [x, -y], [x, y], [-x, y]],
            "altitude_m": altitude_m,
            "line_spacing_m": altitude_m,
            "speed_m_s": 0.5,
            "tilt_deg": 90,
        },
    }
