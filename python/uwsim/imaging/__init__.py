"""Sonars that make pictures: forward-looking, side-scan, and a profiling single beam.

They hear the same scene and water as everything else. A picture is a function of the place, the scenario's seed and a
number (by default simulated time): the same again whenever asked for again, whatever the number of threads. `sim` is a
Simulator or anything with its scene, world, strengths_db, seed, threads and time_ns.

A pose is a matrix (4, 4), world from sonar, the sonar's x axis ahead, y to port, z up. Of a sonar on a vehicle it is
`rov.pose.world_from_body @ imaging.pose_matrix(mount_m, pitch_rad=0.3)`. A head above the water or within the ground
or a solid hears only noise.
"""

from uwsim.imaging.hearing import look_ahead, look_aside, profile
from uwsim.imaging.models import KINDS, Acoustics, ForwardLooking, SideScan, SingleBeam
from uwsim.imaging.native import Place, check
from uwsim.imaging.poses import Matrix, checked_pose, pose_matrix
from uwsim.imaging.results import Profiles, SonarImage, Waterfall

__all__ = [
    "KINDS",
    "Acoustics",
    "ForwardLooking",
    "Matrix",
    "Place",
    "Profiles",
    "SideScan",
    "SingleBeam",
    "SonarImage",
    "Waterfall",
    "check",
    "checked_pose",
    "look_ahead",
    "look_aside",
    "pose_matrix",
    "profile",
]
