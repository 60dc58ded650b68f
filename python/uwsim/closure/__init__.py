"""Loop closure for a drifted map: overlapping submaps of one flight are matched, and the track is corrected to fit."""

from uwsim.closure.close_loops import ClosedTrack, close_loops
from uwsim.closure.track import PingTrack

__all__ = ["ClosedTrack", "PingTrack", "close_loops"]
