"""Exports a depth grid as an S-102 bathymetric surface in HDF5: depth and uncertainty.

IHO S-102, Bathymetric Surface Product Specification, edition 3.0.0 (2024), ch. 10: one regular grid in a UTM zone, rows
from south to north, depths positive down. A world in another coordinate system is resampled to the nearest cell.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.warp import transform

from uwsim.base.atomic_file import write_atomically
from uwsim.mapping.depth_grid import DepthGrid
from uwsim.mapping.files.formats import GridFormat
from uwsim.mapping.files.georeference import WGS84, Georeference, utm_zone

NO_DATA = np.float32(1e6)
UTM = frozenset((*range(32601, 32661), *range(32701, 32761)))
UTM_DEG = -80.0, 84.0
DEPTH_CS, MEAN_SEA_LEVEL = 6498, 3
ENUMERATIONS = {
    "dataCodingFormat": ("fixedStations", "regularGrid", "ungeorectifiedGrid", "movingPlatform", "irregularGrid",
                         "variableCellSize", "TIN", "fixedStationsStationwise", "featureOrientedRegularGrid"),
    "commonPointRule": ("average", "low", "high", "all"),
    "sequencingRule.type": ("linear", "boustrophedonic", "CantorDiagonal", "spiral", "Morton", "Hilbert"),
    "interpolationType": ("nearestneighbor", "linear", "quadratic", "cubic", "bilinear", "biquadratic", "bicubic"),
    "dataOffsetCode": ("XMin, YMin", "XMax, YMax", "XMax, YMin", "XMin, YMax", "barycenter"),
    "verticalCoordinateBase": ("seaSurface", "verticalDatum", "seaBottom"),
    "verticalDatumReference": ("s100VerticalDatum", "EPSG"),
}  # fmt: skip
"""Values of enumerations, counted from 1."""
UNKNOWN = np.float32(-1.0)
CELL = np.dtype([("depth", "<f4"), ("uncertainty", "<f4")])
TEXT = h5py.string_dtype()
FEATURE = np.dtype(
    [(name, TEXT) for name in ("code", "name", "uom.name", "fillValue", "datatype", "lower", "upper", "closure")]
)
QUANTITIES = [
    ("depth", "depth", "metres", "1000000", "H5T_FLOAT", "-12000", "12000", "closedInterval"),
    ("uncertainty", "uncertainty", "metres", "1000000", "H5T_FLOAT", "0", "12000", "gtLeInterval"),
]


class UtmGrid(NamedTuple):
    """Depths and uncertainties (rows, columns) from the south, or nan; centre of the first; EPSG code of the zone."""

    depth_m: NDArray[np.float64]
    uncertainty_m: NDArray[np.float64]
    east_m: float
    north_m: float
    epsg: int


def write_s102(path: Path, grid: DepthGrid, place: Georeference) -> None:
    """Write depths and their uncertainty at 95 %: as the grid states it, else half a cell.

    Empty cells have no data. Written atomically. Raises OSError, or ValueError without a place on Earth in a UTM zone.
    """
    if place.crs is None:
        raise ValueError(f"{path}: an S-102 needs a place on Earth: give --scenario, of one with earth or a "
                         "georeferenced terrain")  # fmt: skip
    utm = _in_utm(path, grid, place)
    rows, columns = utm.depth_m.shape
    known = np.isfinite(utm.depth_m)
    values = np.full((rows, columns), NO_DATA, CELL)
    values["depth"][known] = utm.depth_m[known]
    stated = np.isfinite(utm.uncertainty_m)
    values["uncertainty"][stated] = utm.uncertainty_m[stated]
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=("earliest", "v110"), track_order=False) as file:
        _put_root(file, utm, grid.cell_m)
        feature = file.create_group("BathymetryCoverage")
        feature.attrs.update({
            "dimension": np.uint8(2), "horizontalPositionUncertainty": UNKNOWN, "verticalUncertainty": UNKNOWN,
            "numInstances": np.uint8(1), "sequencingRule.scanDirection": "Easting, Northing",
        })  # fmt: skip
        _put_enumerations(feature, {
            "dataCodingFormat": "regularGrid", "commonPointRule": "low", "sequencingRule.type": "linear",
            "interpolationType": "nearestneighbor", "dataOffsetCode": "barycenter",
        })  # fmt: skip
        feature.create_dataset("axisNames", data=np.array(["Easting", "Northing"], TEXT), track_times=False)
        coverage = feature.create_group("BathymetryCoverage.01")
        east_m, north_m = utm.east_m + grid.cell_m * (columns - 1), utm.north_m + grid.cell_m * (rows - 1)
        coverage.attrs.update({
            "westBoundLongitude": np.float32(utm.east_m), "eastBoundLongitude": np.float32(east_m),
            "southBoundLatitude": np.float32(utm.north_m), "northBoundLatitude": np.float32(north_m),
            "numGRP": np.uint8(1), "gridOriginLongitude": utm.east_m, "gridOriginLatitude": utm.north_m,
            "gridSpacingLongitudinal": grid.cell_m, "gridSpacingLatitudinal": grid.cell_m,
            "numPointsLongitudinal": np.uint32(columns), "numPointsLatitudinal": np.uint32(rows),
            "startSequence": "0,0",
        })  # fmt: skip
        group = coverage.create_group("Group_001")
        depths = utm.depth_m[known]
        errors = utm.uncertainty_m[stated] if stated.any() else np.array([NO_DATA])
        group.attrs.update({
            "minimumDepth": np.float32(depths.min()), "maximumDepth": np.float32(depths.max()),
            "minimumUncertainty": np.float32(errors.min()), "maximumUncertainty": np.float32(errors.max()),
        })  # fmt: skip
        group.create_dataset("values", data=values, compression="gzip", track_times=False)
    write_atomically(path, memory.getvalue())


def _put_root(file: Any, utm: UtmGrid, cell_m: float) -> None:
    rows, columns = utm.depth_m.shape
    east, north = utm.east_m + cell_m * np.array([0, columns - 1]), utm.north_m + cell_m * np.array([0, rows - 1])
    corners = np.meshgrid(east, north)
    longitude, latitude = transform(CRS.from_epsg(utm.epsg), WGS84, *(each.ravel() for each in corners))
    file.attrs.update({
        "productSpecification": "INT.IHO.S-102.3.0.0", "issueDate": "20200101", "horizontalCRS": np.int32(utm.epsg),
        "geographicIdentifier": "a simulated sea floor, made by uwsim",
        "westBoundLongitude": np.float32(min(longitude)), "eastBoundLongitude": np.float32(max(longitude)),
        "southBoundLatitude": np.float32(min(latitude)), "northBoundLatitude": np.float32(max(latitude)),
        "verticalCS": np.int32(DEPTH_CS), "verticalDatum": np.uint16(MEAN_SEA_LEVEL),
    })  # fmt: skip
    _put_enumerations(file, {"verticalCoordinateBase": "verticalDatum", "verticalDatumReference": "s100VerticalDatum"})
    group = file.create_group("Group_F")
    group.create_dataset("featureCode", data=np.array(["BathymetryCoverage"], TEXT), track_times=False)
    group.create_dataset("BathymetryCoverage", data=np.array(QUANTITIES, FEATURE), track_times=False)


def _put_enumerations(group: Any, values: dict[str, str]) -> None:
    for name, value in values.items():
        numbers = {each: k for k, each in enumerate(ENUMERATIONS[name], 1)}
        group.attrs.create(name, numbers[value], dtype=h5py.enum_dtype(numbers, basetype="u1"))


def _in_utm(path: Path, grid: DepthGrid, place: Georeference) -> UtmGrid:
    """Return the grid in its UTM zone: as it is, or the nearest cell of each. Raises ValueError."""
    assert place.crs is not None
    half = 0.5 * grid.cell_m
    error_m = np.where(np.isfinite(grid.depth_m), half, np.nan) if grid.uncertainty_m is None else grid.uncertainty_m
    own = place.crs.to_epsg()
    if own in UTM and place.units_per_m == 1.0:
        x, y = place.origin
        return UtmGrid(grid.depth_m, error_m, x + grid.west_m + half, y + grid.south_m + half, own)
    west, east, south, north = grid.extent_m
    latitude, longitude = place.degrees([0.5 * (west + east), 0.5 * (south + north)]).tolist()
    if not UTM_DEG[0] <= latitude <= UTM_DEG[1]:
        raise ValueError(f"{path}: an S-102 lies in a UTM zone: {latitude:.2f} N must be from 80 S to 84 N")
    epsg = utm_zone(latitude, longitude)
    rows, columns = grid.depth_m.shape
    edges = np.meshgrid(np.linspace(west + half, east - half, columns), np.linspace(south + half, north - half, rows))
    to = CRS.from_epsg(epsg)
    border = np.ones((rows, columns), bool)
    border[1:-1, 1:-1] = False
    there = [np.array(each) for each in transform(place.crs, to, *(_of(place, k, edges[k][border]) for k in (0, 1)))]
    low, high = ([round(float(of(each)) / grid.cell_m) for each in there] for of in (np.min, np.max))
    centres = np.meshgrid(*(grid.cell_m * np.arange(a, b + 1) for a, b in zip(low, high, strict=True)))
    here = [np.array(each) for each in transform(to, place.crs, *(each.ravel() for each in centres))]
    column, row = (
        np.floor(((here[k] - place.origin[k]) / place.units_per_m - (west, south)[k]) / grid.cell_m).astype(int)
        for k in (0, 1)
    )
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    found = np.full((2, len(column)), np.nan)
    found[:, inside] = grid.depth_m[row[inside], column[inside]], error_m[row[inside], column[inside]]
    depths, errors = (each.reshape(centres[0].shape) for each in found)
    return UtmGrid(depths, errors, low[0] * grid.cell_m, low[1] * grid.cell_m, epsg)


def _of(place: Georeference, axis: int, world_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return place.origin[axis] + place.units_per_m * world_m


S102 = GridFormat(write_s102)
