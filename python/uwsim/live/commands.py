"""The commands that a log can name: functions of a simulator whose arguments are plain values, by name.

A new command is one function here: its first parameter is the simulator, the others are keywords. All raise ValueError,
changing nothing, for values that are out of range.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from uwsim.simulator import Simulator
from uwsim.vehicle import Vehicle

T = TypeVar("T")
ALL_STOP = "all_stop"


def release(sim: Simulator, vehicle: str) -> None:
    """Leave the station."""
    _vehicle(sim, vehicle).release()


def undock(sim: Simulator, vehicle: str) -> None:
    """Leave the station for free water; see Vehicle.undock."""
    _vehicle(sim, vehicle).undock()


def dock(sim: Simulator, vehicle: str) -> None:
    """Return to the station; see Vehicle.dock."""
    _vehicle(sim, vehicle).dock()


def all_stop(sim: Simulator, vehicle: str, on: bool = True) -> None:
    """Stop a vehicle against all other commands until released; see Vehicle.all_stop."""
    _vehicle(sim, vehicle).all_stop(on)


def inject_fault(sim: Simulator, kind: str, **figures: Any) -> None:
    """Let something fail; see Simulator.faults."""
    sim.faults.inject(kind, **figures)


def end_fault(sim: Simulator, name: str) -> None:
    """End a fault for good; see Simulator.faults."""
    sim.faults.end(name)


def override_failsafe(sim: Simulator, vehicle: str) -> None:
    """Take a vehicle back from its failsafe; see Vehicle.override_failsafe."""
    _vehicle(sim, vehicle).override_failsafe()


def set_effort(sim: Simulator, vehicle: str, **effort: float) -> None:
    """Command efforts; see Vehicle.set_effort."""
    _vehicle(sim, vehicle).set_effort(**effort)


def set_wrench(
    sim: Simulator, vehicle: str, force_body_n: Sequence[float], torque_body_nm: Sequence[float] = (0.0, 0.0, 0.0)
) -> None:
    """Command force and torque; see Vehicle.set_wrench."""
    _vehicle(sim, vehicle).set_wrench(force_body_n, torque_body_nm)


def set_thrusters(sim: Simulator, vehicle: str, commands: Mapping[str, float]) -> None:
    """Command thrusters by name; see Vehicle.set_thrusters."""
    _vehicle(sim, vehicle).set_thrusters(commands)


def set_fins(sim: Simulator, vehicle: str, angles_rad: Mapping[str, float]) -> None:
    """Command fins by name; see Vehicle.set_fins."""
    _vehicle(sim, vehicle).set_fins(angles_rad)


def place(
    sim: Simulator,
    vehicle: str,
    position_world_m: Sequence[float],
    orientation_xyzw: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
    velocity_body: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
) -> None:
    """Put a vehicle at a pose; see Vehicle.place."""
    _vehicle(sim, vehicle).place(position_world_m, orientation_xyzw, velocity_body)


def start_navigation(sim: Simulator, vehicle: str) -> None:
    """Start a vehicle's estimate, if it has not begun; see Vehicle.estimate."""
    _ = _vehicle(sim, vehicle).estimate


def aim(sim: Simulator, vehicle: str, elevation_rad: float, sonar: str | None = None) -> None:
    """Turn a sonar's head, by default the first's; see Sonar.aim."""
    rov = _vehicle(sim, vehicle)
    head = rov.sonar if sonar is None else _item(rov.sonars, sonar, f"vehicle '{vehicle}' sonar")
    head.aim(elevation_rad)


def set_lamp(sim: Simulator, vehicle: str, lamp: str, on: bool) -> None:
    """Switch a vehicle's lamps."""
    _item(_vehicle(sim, vehicle).lamps, lamp, f"vehicle '{vehicle}' lamp").on = on


def aim_camera(
    sim: Simulator,
    camera: str,
    vehicle: str | None = None,
    pan_rad: float | None = None,
    tilt_rad: float | None = None,
) -> None:
    """Turn a vehicle's camera, or one of the station's if no vehicle is named; see Camera.aim."""
    cameras = sim.cameras if vehicle is None else _vehicle(sim, vehicle).cameras
    _item(cameras, camera, "camera" if vehicle is None else f"vehicle '{vehicle}' camera").aim(pan_rad, tilt_rad)


def set_parameter(sim: Simulator, name: str, value: Any) -> None:
    """Set a parameter; see Simulator.parameters."""
    sim.parameters[name] = value


def set_parameters(sim: Simulator, changes: Mapping[str, Any]) -> None:
    """Set several parameters at once; see Simulator.parameters."""
    sim.parameters.update(changes)


def reset_parameters(sim: Simulator, name: str | None = None) -> None:
    """Return to the scenario's values: one, all below a name, or all."""
    sim.parameters.reset(name)


def set_optics(sim: Simulator, **changes: Any) -> None:
    """Change the light; see Simulator.set_optics."""
    sim.set_optics(**changes)


def link_send(
    sim: Simulator,
    sender: str,
    receiver: str,
    topic: str,
    payload: bytes,
    priority: int = 0,
    lifetime_s: float | None = None,
    replaces: bool = False,
    repeats: int = 0,
) -> None:
    """Give the link a message; see Network.send."""
    if sim.link is None:
        raise ValueError("link_send: the scenario has no link")
    sim.link.send(
        sender, receiver, topic, payload, priority=priority, lifetime_s=lifetime_s, replaces=replaces,
        repeats=repeats,
    )  # fmt: skip


COMMANDS: dict[str, Callable[..., Any]] = {
    command.__name__: command
    for command in (
        release,
        undock,
        dock,
        override_failsafe,
        all_stop,
        inject_fault,
        end_fault,
        set_effort,
        set_wrench,
        set_thrusters,
        set_fins,
        place,
        start_navigation,
        aim,
        set_lamp,
        aim_camera,
        set_optics,
        set_parameter,
        set_parameters,
        reset_parameters,
        link_send,
    )
}
"""Every command by its name, except `reset`, which belongs to LiveSimulator."""


def bound_command(name: str, arguments: Mapping[str, Any]) -> Callable[[Simulator], Any]:
    """Return the command as a function of the simulator. Raises ValueError for an unknown name or keyword."""
    if name not in COMMANDS:
        raise ValueError(f"command = {name!r}: must be one of {', '.join(COMMANDS)}")
    command = COMMANDS[name]
    if command is set_effort:
        unknown = sorted(set(arguments) - {"vehicle"} - set(inspect.signature(Vehicle.set_effort).parameters))
        if unknown:
            raise ValueError(f"command 'set_effort': {unknown[0]!r}: is no axis")
    try:
        inspect.signature(command).bind(None, **arguments)
    except TypeError as error:
        raise ValueError(f"command '{name}': {error}") from None
    return lambda sim: command(sim, **arguments)


def _vehicle(sim: Simulator, name: str) -> Vehicle:
    return _item(sim.vehicles, name, "vehicle")


def _item(items: Mapping[str, T], name: str, what: str) -> T:
    if not isinstance(name, str) or name not in items:
        raise ValueError(f"{what} = {name!r}: must be one of {', '.join(items)}")
    return items[name]
