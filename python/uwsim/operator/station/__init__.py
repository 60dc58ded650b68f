"""The operator's station: a web page for flying, and its server."""

from uwsim.operator.station.hub import Station
from uwsim.operator.station.site import Site

__all__ = ["Site", "Station"]
