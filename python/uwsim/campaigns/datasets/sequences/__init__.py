"""Sequences for SLAM: the measurements of a vehicle's instruments on a mission, with calibration and ground truth."""

from uwsim.campaigns.datasets.sequences.make import Sequence, make_sequence

__all__ = ["Sequence", "make_sequence"]
