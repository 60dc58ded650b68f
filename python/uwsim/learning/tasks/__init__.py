"""The tasks, one per file."""

from uwsim.learning.tasks.coverage import Coverage
from uwsim.learning.tasks.docking import Docking
from uwsim.learning.tasks.gate_passing import GatePassing
from uwsim.learning.tasks.pipeline_following import PipelineFollowing
from uwsim.learning.tasks.station_keeping import StationKeeping
from uwsim.learning.tasks.tethered_return import TetheredReturn
from uwsim.learning.tasks.valve import Valve
from uwsim.learning.tasks.waypoint import Waypoint

TASKS = {
    task.__name__: task
    for task in (
        StationKeeping,
        Waypoint,
        PipelineFollowing,
        Docking,
        Coverage,
        GatePassing,
        TetheredReturn,
        Valve,
    )
}

__all__ = [
    "TASKS",
    "Coverage",
    "Docking",
    "GatePassing",
    "PipelineFollowing",
    "StationKeeping",
    "TetheredReturn",
    "Valve",
    "Waypoint",
]
