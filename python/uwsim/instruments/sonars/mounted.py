"""A vehicle's imaging sonars, as described in its YAML file."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

from numpy.typing import ArrayLike

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.sealed import Attached
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import (
    Acoustics,
    ForwardLooking,
    Profiles,
    SideScan,
    SingleBeam,
    SonarImage,
    Waterfall,
)
from uwsim.scenario.spec.imaging_sonar import ImagingMount, imaging_kind
from uwsim.scenario.spec.vehicle_entry import VehicleEntry


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A snapshot from `Simulator.around`, for imaging sonars and depth maps.

    scene: the world and the other vehicles. strengths_db: Lambert strength of each surface's material, by
    Simulator.label_names. materials: how each surface scatters by angle and how it reflects, by the same names.
    """

    scene: _core.RayScene
    world: _core.World
    strengths_db: Mapping[str, float]
    seed: int
    threads: int
    time_ns: int
    materials: Mapping[str, _core.BottomMaterial] = field(default_factory=dict)


class Fleet(imaging.Place, Protocol):
    """The part of a simulator that sonars on its vehicles need."""

    @property
    def vehicles(self) -> Mapping[str, Any]:
        """The vehicles, keyed by name; each has a pose."""

    def around(self, vehicle: str | None = None) -> Surroundings:
        """Return the surroundings of a sonar on a vehicle."""


class ImagingSonar(Attached):
    """An imaging sonar on a vehicle; its pings include the other vehicles.

    Pinging does not advance simulated time, and all pings at one time are equal. model: its parameters, an instance of
    one of the model classes in uwsim.instruments.sonars.imaging.
    """

    name: str
    model: Acoustics

    def __init__(self, sim: Fleet, vehicle: str, name: str, mount: ImagingMount, model: Acoustics) -> None:
        self._sim = sim
        self._vehicle = vehicle
        self._body_from_sonar = mount.body_from_sonar()
        self._kind = imaging_kind(mount.kind)
        self.name = name
        self.model = model

    def __repr__(self) -> str:
        return f"<ImagingSonar '{self.name}' ({type(self.model).__name__})>"

    def change(self, model: Acoustics) -> None:
        """Replace the sonar's parameters. Simulator.parameters calls this."""
        self.__dict__["model"] = model

    @property
    def world_from_sonar(self) -> Floats:
        """The sonar's current pose, (4, 4)."""
        return imaging.checked_pose(self._sim.vehicles[self._vehicle].pose.world_from_body @ self._body_from_sonar)

    def ping(self, *arguments: Any, with_labels: bool = False) -> Any:
        """Ping once from the current pose. The arguments and the result depend on the kind; see look, line and profile.

        with_labels: whether to include the surface shown in each cell.
        """
        return self.later(*arguments, with_labels=with_labels)()

    def later(self, *arguments: Any, with_labels: bool = False) -> Callable[[], Any]:
        """Store the current state; return a function that pings from it at any time, on any thread; see `ping`."""
        self._require_fitting(arguments)
        around, pose, model = self._sim.around(self._vehicle), self.world_from_sonar, self.model
        return lambda: self._kind.ping(around, pose, model, self.stream, *arguments, with_labels=with_labels)

    def look(self, *, with_labels: bool = False) -> SonarImage:
        """Return a picture from a forward-looking sonar. Raises ValueError for any other kind of sonar."""
        self._require(ForwardLooking)
        return cast(SonarImage, self.ping(with_labels=with_labels))

    def line(self, *, with_labels: bool = False) -> Waterfall:
        """Return one side-scan sonar ping as a one-row waterfall. Raises ValueError for any other kind of sonar."""
        self._require(SideScan)
        return cast(Waterfall, self.ping(with_labels=with_labels))

    def profile(self, angles_rad: ArrayLike, *, with_labels: bool = False) -> Profiles:
        """Return single-beam pings at angles (n,) from the current pose. Raises ValueError for other kinds of sonar."""
        self._require(SingleBeam)
        return cast(Profiles, self.ping(angles_rad, with_labels=with_labels))

    @property
    def stream(self) -> str:
        """The name of the sonar's random stream, such as rov/forward_looking."""
        return _core.stream_name(self._vehicle, self.name)

    def _require_fitting(self, arguments: tuple[Any, ...]) -> None:
        """Raise TypeError unless these are the arguments of this kind's ping, after those that every kind has."""
        wanted = [name for name in list(inspect.signature(self._kind.ping).parameters)[4:] if name != "with_labels"]
        if len(arguments) != len(wanted):
            expected = f"{', '.join(wanted) or 'no arguments'}, and with_labels by name"
            raise TypeError(f"imaging_sonars['{self.name}'].ping(): takes {expected}; {len(arguments)} given")

    def _require(self, kind: type[Acoustics]) -> None:
        if not isinstance(self.model, kind):
            raise ValueError(f"imaging_sonars['{self.name}'] is {type(self.model).__name__}: must be {kind.__name__}")


def checked_model(place: imaging.Place, mount: ImagingMount) -> Acoustics:
    """Return the model of a mounted sonar. Raises ValueError if it is invalid."""
    model: Acoustics = imaging_kind(mount.kind).model(**mount.figures)
    imaging.check(model, place)
    return model


def imaging_models(place: imaging.Place, vehicle: VehicleEntry) -> dict[str, Acoustics]:
    """Return the models of a vehicle's imaging sonars, keyed by name. Raises ValueError if one is invalid."""
    return {name: checked_model(place, mount) for name, mount in vehicle.model.imaging_sonars.items()}


def imaging_sonars(sim: Fleet, vehicle: VehicleEntry, models: Mapping[str, Acoustics]) -> dict[str, ImagingSonar]:
    """Return a vehicle's imaging sonars, keyed by name. models: see `imaging_models`."""
    mounts = vehicle.model.imaging_sonars
    return {name: ImagingSonar(sim, vehicle.name, name, mounts[name], model) for name, model in models.items()}
