"""The terrain `raster`: elevations from a GeoTIFF, an ESRI ASCII grid or any other format that GDAL can read."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario.spec.fields import AssetFile, Factor, InRange, Size
from uwsim.scenario.spec.terrain import LOCAL, TerrainModel

Coordinate = Annotated[float, InRange(-1e9, 1e9)]


class RasterTerrain(TerrainModel):
    """An elevation grid that GDAL can read: GeoTIFF, ESRI ASCII (.asc) and others that contain elevations themselves.

    file: the grid. band: band to use in a file with several, counted from 1. interpolation: method between its cells.
    crs: coordinate system, such as EPSG:4326, which overrides the file's; `local` for plain metres. If neither names
    one, a file whose cells look like degrees is read as EPSG:4326, any other as local. Degrees, and coordinates of a
    projection that is not true to scale there, such as Web Mercator, are projected to metres by a transverse Mercator
    projection centred on the terrain. unit: of the heights, `m`, `ft` or `us-ft`; by default that of the band or of the
    vertical reference. nodata: the value of cells without data, in the file's unit, in addition to those that the file
    declares. positive: `down` for depths. water_level_m: elevation of the water surface; it becomes z = 0.
    horizontal_scale: simulated metres per real metre; 0.05 makes 10 km a 500 m lake. vertical_scale: simulated metres
    per real metre of height. centre: centre of the terrain in the file's coordinates (longitude, latitude or easting,
    northing); by default the file's centre. size_m: simulated extent; by default the largest that fits.
    fill_nodata: interpolate cells without data; without it, the terrain must not include any.
    """

    source: Literal["raster"]
    file: AssetFile = Field(examples=["terrains/jacksboro_srtm.asc"])
    band: Annotated[int, InRange(1, 1000)] | None = None
    crs: str | None = Field(default=None, examples=["EPSG:4326"])
    unit: Literal["m", "ft", "us-ft"] | None = None
    nodata: Annotated[float, InRange(-1e38, 1e38)] | None = None
    positive: Literal["up", "down"] = "up"
    water_level_m: Annotated[float, InRange(-12_000, 10_000, "m")] = Field(examples=[550])
    horizontal_scale: Factor = Field(default=1.0, examples=[0.05])
    vertical_scale: Factor = Field(default=1.0, examples=[0.11])
    centre: tuple[Coordinate, Coordinate] | None = Field(default=None, examples=[[-84.19, 36.6]])
    size_m: tuple[Size, Size] | None = Field(default=None, examples=[[440, 320]])
    interpolation: Literal["cubic", "linear"] = "cubic"
    fill_nodata: bool = False

    @property
    def has_place(self) -> bool:
        """See TerrainModel."""
        return self.crs != LOCAL

    def place(self) -> Georeference:
        """See TerrainModel."""
        from uwsim.scenario.terrains.elevations import raster_place

        return raster_place(self)

    def heights(self) -> NDArray[np.floating]:
        """See TerrainModel."""
        from uwsim.scenario.terrains.elevations import raster_heights  # here, since rasterio takes half a second

        return raster_heights(self)
