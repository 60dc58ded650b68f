"""Sequences for SLAM: what a vehicle's instruments measure along a mission, with calibration and ground truth."""

from uwsim.campaigns.datasets.sequences.make import Sequence, make_sequence

__all__ = ["Sequence", "make_sequence"]
