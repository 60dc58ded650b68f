"""The location of a scenario's world on Earth."""

from __future__ import annotations

from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario import Scenario
from uwsim.scenario.terrains.raster import RasterTerrain


def georeference(scenario: Scenario | None) -> Georeference:
    """Return the georeference of a scenario with an elevation raster or the key `earth`; local metres for any other.

    Raises MissingExtraError without rasterio.
    """
    if scenario is None or not (scenario.earth or isinstance(scenario.terrain, RasterTerrain)):
        return Georeference()
    from uwsim.scenario.terrains.elevations import metres_about, raster_place  # rasterio takes half a second

    if scenario.earth is not None:
        return Georeference(metres_about((scenario.earth.longitude_deg, scenario.earth.latitude_deg)))
    assert isinstance(scenario.terrain, RasterTerrain)
    place = raster_place(scenario.terrain)
    return Georeference(place.crs, place.origin, place.units_per_m)
