"""Imaging sonars that a vehicle carries, as its YAML file says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, TypeVar

from numpy.typing import ArrayLike

from uwsim import imaging
from uwsim.imaging import ForwardLooking, Matrix, Profiles, SideScan, SingleBeam, SonarImage, Waterfall
from uwsim.scenario.imaging_spec import ImagingMount
from uwsim.scenario.schema import Vehicle

Kind = TypeVar("Kind", bound=imaging.Acoustics)


class Fleet(imaging.Place, Protocol):
    """A simulator with its vehicles."""

    @property
    def vehicles(self) -> Mapping[str, Any]:
        """By name; each has a pose."""


class ImagingSonar:
    """An imaging sonar on a vehicle. What it hears at one time is always the same; hearing does not advance time.

    name, and model: what it is, one of uwsim.imaging's.
    """

    def __init__(self, sim: Fleet, vehicle: str, name: str, mount: ImagingMount) -> None:
        self._sim = sim
        self._vehicle = vehicle
        self._body_from_sonar = mount.body_from_sonar()
        self.name = name
        self.model = mount.sonar()
        imaging.check(self.model, sim)

    @property
    def world_from_sonar(self) -> Matrix:
        """(4, 4) where it is now."""
        return imaging.checked_pose(self._sim.vehicles[self._vehicle].pose.world_from_body @ self._body_from_sonar)

    def look(self) -> SonarImage:
        """A forward-looking sonar's picture. Raises ValueError of another kind."""
        model = self._model_of(ForwardLooking)
        return imaging.look_ahead(self._sim, self.world_from_sonar, model, name=self._stream)

    def line(self) -> Waterfall:
        """A side-scan's one ping from here, a waterfall of one row. Raises ValueError of another kind."""
        model, now = self._model_of(SideScan), self._sim.time_ns
        return imaging.look_aside(self._sim, [self.world_from_sonar], model, name=self._stream, first_ping=now)

    def profile(self, angles_rad: ArrayLike) -> Profiles:
        """A single beam's pings at angles (n,), all from here. Raises ValueError of another kind."""
        model, now = self._model_of(SingleBeam), self._sim.time_ns
        return imaging.profile(self._sim, self.world_from_sonar, angles_rad, model, name=self._stream, first_ping=now)

    @property
    def _stream(self) -> str:
        return f"{self._vehicle}/{self.name}"

    def _model_of(self, kind: type[Kind]) -> Kind:
        if not isinstance(self.model, kind):
            raise ValueError(f"imaging_sonars['{self.name}'] is {type(self.model).__name__}: must be {kind.__name__}")
        return self.model


def imaging_sonars(sim: Fleet, vehicle: Vehicle) -> dict[str, ImagingSonar]:
    """All that the vehicle's file names."""
    mounts = vehicle.model.imaging_sonars
    return {name: ImagingSonar(sim, vehicle.name, name, mount) for name, mount in mounts.items()}
