"""A scenario's terrain: from noise, an elevation raster, or the grey levels of an image."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import AssetFile, Factor, InRange, Metres, Model, Point2, Size, broken

MAX_NODES = 16_000_000
"""4,000 x 4,000 nodes: 64 MB of heights, and some 3 GB of triangles for ray casting."""

Spacing = Annotated[float, InRange(0.02, 100, "m")]
Coordinate = Annotated[float, InRange(-1e9, 1e9)]


class Grid(Model):
    """The grid common to all terrains. Its centre is the world's origin.

    size_m: extent along x (east) and y (north), a whole number of spacings. spacing_m: distance between neighbouring
    heights. source: source of the heights; each source has its own keys. window_m: corners (x, y), south-west and
    north-east, of the part that is built, extended to whole cells; the heights and the world's origin are those of the
    whole terrain. It allows parts of a very large survey to be flown in separate processes, none of which holds the
    whole terrain.
    """

    spacing_m: Spacing = 0.5
    window_m: tuple[Point2, Point2] | None = None

    @model_validator(mode="after")
    def _window_has_some_size(self) -> Grid:
        if self.window_m is not None:
            (x0, y0), (x1, y1) = self.window_m
            if x0 >= x1 or y0 >= y1:
                raise broken("its second corner must be north-east of its first", at=("window_m",))
        return self

    @staticmethod
    def _check_grid(size_m: tuple[float, float], spacing_m: float) -> None:
        cells = [size / spacing_m for size in size_m]
        for size, count in zip(size_m, cells, strict=True):
            if abs(count - round(count)) > 1e-6 or round(count) < 1:
                raise broken(
                    f"must be a whole number of spacing_m ({spacing_m:g} m)", at=("size_m",), value=size, unit="m"
                )
        nodes = (round(cells[0]) + 1) * (round(cells[1]) + 1)
        if nodes > MAX_NODES:
            rule = f"makes {nodes} heights, must be at most {MAX_NODES}: enlarge it or make size_m smaller"
            raise broken(rule, at=("spacing_m",), value=spacing_m, unit="m")


class Rim(Model):
    """Hills around the lake, above water everywhere along the terrain's edge.

    height_m: mean height of the crest, which varies by half of that. width_m: distance over which the bed rises to the
    crest.
    """

    height_m: Annotated[float, InRange(0.1, 1000, "m")]
    width_m: Size


class NoiseTerrain(Grid):
    """A bed of fractal OpenSimplex2 noise, ringed by hills.

    seed: seed of this noise; separate from the scenario's seed, so that the terrain is unchanged when the sensors'
    noise changes. bed_depth_m: mean depth of the bed. hill_height_m: largest deviation of the bed from it, up and down.
    hill_wavelength_m: wavelength of the broadest hills. octaves: number of octaves of noise; each additional one halves
    the wavelength. gain: ratio of heights between successive octaves. rim: hills around the lake, above the water; none
    by default.
    """

    source: Literal["noise"]
    size_m: tuple[Size, Size]
    seed: Annotated[int, InRange(0, 2**31 - 2)] = 0
    bed_depth_m: Annotated[float, InRange(0, 1000, "m")]
    hill_height_m: Annotated[float, InRange(0, 500, "m")] = 0.0
    hill_wavelength_m: Size = 100.0
    octaves: Annotated[int, InRange(1, 8)] = 5
    gain: Annotated[float, InRange(0.01, 0.99)] = 0.4
    rim: Rim | None = None

    @model_validator(mode="after")
    def _fits(self) -> NoiseTerrain:
        self._check_grid(self.size_m, self.spacing_m)
        return self


class RasterTerrain(Grid):
    """An elevation grid that GDAL can read: GeoTIFF, ESRI ASCII (.asc) and others that contain elevations themselves.

    file: the grid. band: band to use in a file with several, counted from 1. interpolation: method between its cells.
    crs: coordinate system, such as EPSG:4326, which overrides the file's; `local` for plain metres. If neither names
    one, a file whose cells look like degrees is read as EPSG:4326, any other as local. Degrees are projected to metres
    by a transverse Mercator projection centred on the terrain. water_level_m: elevation of the water surface in the
    file's own units; it becomes z = 0. horizontal_scale: simulated metres per real metre; 0.05 makes 10 km a 500 m
    lake. vertical_scale: simulated metres per real metre of height. centre: centre of the terrain in the file's
    coordinates (longitude, latitude or easting, northing); by default the file's centre. size_m: simulated extent; by
    default the largest that fits.
    fill_nodata: interpolate cells without data; without it, the terrain must not include any.
    """

    source: Literal["raster"]
    file: AssetFile
    band: Annotated[int, InRange(1, 1000)] | None = None
    crs: str | None = None
    water_level_m: Annotated[float, InRange(-12_000, 10_000, "m")]
    horizontal_scale: Factor = 1.0
    vertical_scale: Factor = 1.0
    centre: tuple[Coordinate, Coordinate] | None = None
    size_m: tuple[Size, Size] | None = None
    interpolation: Literal["cubic", "linear"] = "cubic"
    fill_nodata: bool = False

    @model_validator(mode="after")
    def _fits(self) -> RasterTerrain:
        if self.size_m is not None:
            self._check_grid(self.size_m, self.spacing_m)
        return self


class ImageTerrain(Grid):
    """Terrain heights from the grey levels of an 8- or 16-bit image. The first row is the northern edge.

    The centres of the outermost pixels lie on the terrain's edge. file: the image. interpolation: method between its
    pixels. black_m, white_m: z at grey level 0 and at the highest one (255 or 65535).
    """

    source: Literal["image"]
    file: AssetFile
    size_m: tuple[Size, Size]
    black_m: Metres
    white_m: Metres
    interpolation: Literal["cubic", "linear"] = "cubic"

    @model_validator(mode="after")
    def _fits(self) -> ImageTerrain:
        self._check_grid(self.size_m, self.spacing_m)
        return self


TerrainSpec = Annotated[NoiseTerrain | RasterTerrain | ImageTerrain, Field(discriminator="source")]
