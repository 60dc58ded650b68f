"""The location of a scenario's world on Earth."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uwsim.mapping.files.georeference import Georeference, metres_about

if TYPE_CHECKING:  # a scenario is built with its place
    from uwsim.scenario.spec.scenario import Scenario


def georeference(scenario: Scenario | None) -> Georeference:
    """Return the georeference of a scenario with an elevation raster or the key `earth`; local metres for any other.

    Raises MissingExtraError without rasterio.
    """
    if scenario is None:
        return Georeference()
    if scenario.earth is None:
        return scenario.terrain.place()
    return Georeference(metres_about((scenario.earth.longitude_deg, scenario.earth.latitude_deg)))
