"""Draws what a scenario's first vehicle sees, from the scenario's view, for the start screen."""

from __future__ import annotations

from functools import cache

from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario import Scenario, load
from uwsim.simulator.simulator import Simulator

WIDTH, QUALITY = 480, 82


@cache
def still_jpg(name: str) -> bytes:
    """Return the still of a named scenario as JPEG. It is cached. Raises ScenarioError, LookupError or OSError."""
    return still(load(name))


def still(scenario: Scenario) -> bytes:
    """Return a scenario's still as JPEG: from its view or, without one, from behind the vehicle at its start.

    Raises LookupError for a vehicle without cameras.
    """
    sim = Simulator(scenario)
    cameras, view = sim.rov.cameras, scenario.view
    if view is not None:
        sim.rov.place(view.position_m, of_yaw_pitch_roll_deg((view.yaw_deg, view.pitch_deg, 0.0)))
    wanted = [name for name, camera in cameras.items() if (camera.mount.follows == "heading") == (view is None)]
    if not (names := wanted or list(cameras)):
        raise LookupError(f"vehicle '{sim.rov.name}' has no camera")
    return bytes(cameras[names[0]].resized(WIDTH).capture(dark_below_ground=True).jpeg(QUALITY))
