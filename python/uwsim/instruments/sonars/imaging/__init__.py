"""Imaging sonars: forward-looking, side-scan, and a profiling single beam, one file each.

They ping in the same scene and water as every other sensor. A picture is a function of the pose, the scenario's seed
and a number (by default simulated time): repeated calls give the same picture for any number of threads. `sim` is
a Simulator or anything with its scene, world, strengths_db, seed, threads and time_ns.

A pose is a matrix (4, 4), world from sonar, with the sonar's x axis ahead, y to port, z up. For a sonar on a vehicle it
is `rov.pose.world_from_body @ imaging.pose_matrix(mount_m, pitch_rad=0.3)`, and `sim.around("rov")` is its
surroundings, with the other vehicles; a Simulator's own scene is the world alone. A head above the water, in the ground
or in a solid receives only noise.
"""

from uwsim.instruments.sonars.imaging import forward_looking, side_scan, single_beam
from uwsim.instruments.sonars.imaging.acoustics import Acoustics, ImagingKind, Place, check
from uwsim.instruments.sonars.imaging.forward_looking import ForwardLooking, SonarImage, look_ahead
from uwsim.instruments.sonars.imaging.side_scan import SideScan, Waterfall, look_aside
from uwsim.instruments.sonars.imaging.single_beam import Profiles, SingleBeam, profile
from uwsim.instruments.sonars.poses import Matrix, checked_pose, pose_matrix

KINDS: dict[str, ImagingKind] = {
    kind.model.kind: kind for kind in (forward_looking.KIND, side_scan.KIND, single_beam.KIND)
}
"""All kinds by their names in YAML. A new kind is one C++ file, one Python file and an entry in the table of each."""

__all__ = [
    "KINDS",
    "Acoustics",
    "ForwardLooking",
    "ImagingKind",
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
