"""The operator's station: a web page for flying, and its server."""

from uwsim.operator.station.site.site import Site
from uwsim.operator.station.station import Station

__all__ = ["Site", "Station"]
