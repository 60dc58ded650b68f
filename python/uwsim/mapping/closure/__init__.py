"""Loop closure: matches overlapping submaps of a flight and corrects the track for drift accordingly."""

from uwsim.mapping.closure.close_loops import ClosedTrack, close_loops
from uwsim.mapping.closure.track import PingTrack

__all__ = ["ClosedTrack", "PingTrack", "close_loops"]
