"""The location of a scenario's world on Earth."""

from __future__ import annotations

from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario import Scenario
from uwsim.scenario.terrains.raster import RasterTerrain


def georeference(scenario: Scenario | None) -> Georeference:
    """Return the georeference of a scenario with an elevation raster; local metres for any other."""
    if scenario is None or not isinstance(scenario.terrain, RasterTerrain):
        return Georeference()
    from uwsim.scenario.terrains.elevations import raster_place  # imported here: rasterio takes half a second

    place = raster_place(scenario.terrain)
    return Georeference(place.crs, place.origin, place.units_per_m)
