"""From where a scenario is shown."""

from __future__ import annotations

from uwsim.scenario.spec.fields import Degrees, Model, NoseDown, Point3


class View(Model):
    """A pose of the first vehicle from which its cameras show what the scenario is about. No flight uses it.

    position_m: of the vehicle. yaw_deg: its heading, counter-clockwise from east. pitch_deg: positive nose down.
    """

    position_m: Point3
    yaw_deg: Degrees = 0.0
    pitch_deg: NoseDown = 0.0
