"""Lamp: the lamps on one switch, whose light all cameras see."""

from __future__ import annotations

import math

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.journal import Journal
from uwsim.base.quaternions import about_z
from uwsim.base.sealed import Attached
from uwsim.scenario.build.camera import core_lamp, mount_orientation_xyzw
from uwsim.scenario.build.station import in_world
from uwsim.scenario.spec.camera import Lamps
from uwsim.scenario.spec.settings import Station


class Lamp(Attached):
    """The lamps on one switch, such as rov.lamps["front"]. Their light is visible to every camera."""

    name: str
    spec: Lamps

    def __init__(self, name: str, spec: Lamps) -> None:
        self.name = name
        self.spec = spec
        self._on = spec.on
        self._journal: Journal | None = None
        self._vehicle = ""
        self._orientations_xyzw = [mount_orientation_xyzw(spot.yaw_pitch_roll_deg) for spot in spec.spots]

    def __repr__(self) -> str:
        return f"<Lamp '{self.name}', {'on' if self.on else 'off'}>"

    def change(self, spec: Lamps) -> None:
        """Replace the lamp parameters. Simulator.parameters calls this."""
        self.__dict__["spec"] = spec

    @property
    def on(self) -> bool:
        """Whether the lamps are on. They start off unless the vehicle file sets `on`."""
        return self._on

    @on.setter
    def on(self, value: bool) -> None:
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"lamp '{self.name}': on = {value!r}: must be True or False")
        self._on = bool(value)
        if self._journal is not None and self._journal.observers:
            self._journal.note("set_lamp", vehicle=self._vehicle, lamp=self.name, on=self._on)

    def set_silently(self, on: bool) -> None:
        """Switch the lamps without a journal entry, as part of another command such as a reset."""
        self._on = on

    def report_to(self, journal: Journal, vehicle: str) -> None:
        """Log each switching of the lamps in this journal."""
        self._journal, self._vehicle = journal, vehicle

    def lights(self, position_m: Floats, orientation_xyzw: Floats) -> list[_core.SpotLamp]:
        """Return the lamps for the renderer, placed according to the vehicle pose."""
        lights = []
        for spot, turn in zip(self.spec.spots, self._orientations_xyzw, strict=True):
            position, orientation, _ = _core.mounted_pose(position_m, orientation_xyzw, spot.position_m, turn)
            lights.append(core_lamp(self.spec, position, orientation))
        return lights


def station_lights(station: Station) -> list[_core.SpotLamp]:
    """Return the station's lamps that are on for the renderer, in the world frame."""
    position_m, turn = in_world(station, (0.0, 0.0, 0.0)), about_z(math.radians(station.yaw_deg))
    switches = [Lamp(name, spec) for name, spec in station.lamps.items()]
    return [light for lamp in switches if lamp.on for light in lamp.lights(position_m, turn)]
