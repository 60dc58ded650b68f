"""The meaning of an elevation raster's numbers: their unit, and those that stand for cells without data."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.io import DatasetReader

from uwsim.scenario.read.errors import ScenarioError

if TYPE_CHECKING:
    from uwsim.scenario.terrains.raster import RasterTerrain

FloatGrid = NDArray[np.float64]
UNITS_M = {"m": 1.0, "ft": 0.3048, "us-ft": 1200.0 / 3937.0}
"""Metres per unit, by the names that a scenario may give."""
SPELLINGS_M = {
    "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001,
    "centimetre": 0.01, "centimetres": 0.01, "centimeter": 0.01, "centimeters": 0.01, "km": 1000.0,
    "ft": UNITS_M["ft"], "foot": UNITS_M["ft"], "feet": UNITS_M["ft"], "international foot": UNITS_M["ft"],
    "us-ft": UNITS_M["us-ft"], "ft-us": UNITS_M["us-ft"], "ftus": UNITS_M["us-ft"], "us_ft": UNITS_M["us-ft"],
    "us survey foot": UNITS_M["us-ft"], "us survey feet": UNITS_M["us-ft"], "foot_us": UNITS_M["us-ft"],
    "fathom": 1.8288, "fathoms": 1.8288,
}  # fmt: skip
"""Metres per unit, by the spellings of files. A text such as "metres above MSL" counts by its first word."""
VERTICAL = re.compile(r'VERT(?:_CS|CRS|ICALCRS)\[.*?(?:LENGTH)?UNIT\["([^"]*)",\s*([-+.\deE]+)', re.DOTALL)
GAP = re.compile(r"-?(9{2,}(\.9+)?|999\.25|3276[78])")
"""Numbers that files use for cells without data."""


def height_unit_m(file: DatasetReader, crs: CRS | None, spec: RasterTerrain) -> float:
    """Return metres per unit of a band's heights: that of the scenario, of the band, or of its vertical reference.

    Without any, they are metres, unless the file's horizontal unit is another. Raises ScenarioError where the unit
    has to be asked for.
    """
    if spec.unit is not None:
        return UNITS_M[spec.unit]
    ask = f"give their unit as unit, {', '.join(UNITS_M)} (`uwsim scenario from`: --unit)"
    stated = (file.units[(spec.band or 1) - 1] or "").strip()
    text = stated.strip("[]() ").replace("U.S.", "US").lower()
    if text:
        found = SPELLINGS_M.get(text) or SPELLINGS_M.get(text.split()[0])
        if found is None:
            raise ScenarioError(f"terrain '{spec.file.name}': its heights are in '{stated[:40]}': {ask}", at=("file",))
        return found
    if crs is None:
        return 1.0
    vertical = VERTICAL.search(crs.to_wkt())
    if vertical is not None:
        return float(vertical[2])
    name, factor = crs.linear_units_factor if crs.is_projected else ("metre", 1.0)
    if abs(factor - 1.0) > 1e-6:
        raise ScenarioError(
            f"terrain '{spec.file.name}': its eastings and northings are in '{name}', and the file does not state the "
            f"unit of its heights: {ask}",
            at=("file",),
        )
    return 1.0


def without_gaps(values: FloatGrid, spec: RasterTerrain) -> FloatGrid:
    """Return the values with NaN where the scenario's `nodata` is. Raises ScenarioError for another likely gap.

    Likely is a number that files use for gaps, such as -9999, and that is farther from all others than they are spread.
    """
    if spec.nodata is not None:
        return np.where(np.isclose(values, spec.nodata, rtol=1e-6, atol=0.0), np.nan, values)
    known = values[np.isfinite(values)]
    for value in {float(known.min()), float(known.max())} if known.size else ():
        if not GAP.fullmatch(f"{value:.7g}"):
            continue
        others = known[known != value]
        if others.size and np.abs(others - value).min() > np.ptp(others):
            raise ScenarioError(
                f"terrain '{spec.file.name}': {known.size - others.size} of {known.size} cells are {value:.7g}, far "
                f"from all others ({others.min():.6g} to {others.max():.6g}), and the file does not declare it as "
                f"no data: if it is, give nodata: {value:.7g} (`uwsim scenario from`: --nodata {value:.7g}); if it is "
                "a height, give another number",
                at=("file",),
            )
    return values
