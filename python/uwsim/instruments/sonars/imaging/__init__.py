"""Imaging sonars: forward-looking, side-scan and single-beam profiling, one file per kind.

They ping the same scene through the same water as all other sensors. A picture depends only on the pose, the scenario's
seed and a number (by default the simulated time), which selects the receiver's noise; speckle depends on the pose.
Repeated calls give the same picture, for any number of threads.
`sim` is a Simulator or any object with its scene, world, strengths_db, seed, threads and time_ns.

A pose is a matrix (4, 4), world from sonar, where the sonar's x axis points ahead, y to port, z up. For a sonar on a
vehicle it is `rov.pose.world_from_body @ imaging.pose_matrix(mount_m, pitch_rad=0.3)`, and its surroundings are
`sim.around("rov")`, which includes the other vehicles; a Simulator's own scene has no vehicles. A head above the water,
in the ground or in a solid receives only noise.
"""

from uwsim.instruments.sonars.imaging.acoustics import Acoustics, Place, check
from uwsim.instruments.sonars.imaging.forward_looking import ForwardLooking, SonarImage, look_ahead
from uwsim.instruments.sonars.imaging.side_scan import SideScan, Waterfall, look_aside
from uwsim.instruments.sonars.imaging.single_beam import Profiles, SingleBeam, profile
from uwsim.instruments.sonars.poses import checked_pose, pose_matrix

__all__ = [
    "Acoustics",
    "ForwardLooking",
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
