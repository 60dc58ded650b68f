"""Loop closure for a drifted map: overlapping submaps of one flight are matched, and the track is corrected to fit."""

from uwsim.mapping.closure.close_loops import ClosedTrack, close_loops
from uwsim.mapping.closure.track import PingTrack

__all__ = ["ClosedTrack", "PingTrack", "close_loops"]
