"""Mends a map that has drifted: submaps of one flight are matched where they overlap, and the track is bent to fit."""

from uwsim.closure.close_loops import ClosedTrack, close_loops
from uwsim.closure.track import PingTrack

__all__ = ["ClosedTrack", "PingTrack", "close_loops"]
