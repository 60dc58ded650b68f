"""The table of commands; a new command is one entry here."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from uwsim.base.axes import AXES
from uwsim.base.commands.command import SET_BOOL, TRIGGER, Argument, Command, item
from uwsim.base.commands.holds import HOLDS
from uwsim.base.commands.notes import NOTE

ALL_STOP, SERVO_FRAMES = "all_stop", "servo_frames"
RIGHT_ANGLE_RAD = 0.5 * math.pi


def _aim(vehicle: Any, elevation_rad: float, sonar: str | None = None) -> None:
    head = vehicle.sonar if sonar is None else item(vehicle.sonars, sonar, f"vehicle '{vehicle.name}' sonar")
    head.aim(elevation_rad)


def _set_lamp(vehicle: Any, lamp: str, on: bool) -> None:
    item(vehicle.lamps, lamp, f"vehicle '{vehicle.name}' lamp").on = on


def _aim_camera(carrier: Any, camera: str, pan_rad: float | None = None, tilt_rad: float | None = None) -> None:
    what = "camera" if hasattr(carrier, "vehicles") else f"vehicle '{carrier.name}' camera"
    item(carrier.cameras, camera, what).aim(pan_rad, tilt_rad)


def _drop(vehicle: Any, dropper: str | None = None) -> None:
    chosen = dropper or next((name for name, one in vehicle.droppers.items() if one.loaded), None)
    if chosen is None:
        raise ValueError(f"vehicle '{vehicle.name}': no dropper holds anything")
    item(vehicle.droppers, chosen, f"vehicle '{vehicle.name}' dropper").release()


def _reload(vehicle: Any, dropper: str) -> None:
    item(vehicle.droppers, dropper, f"vehicle '{vehicle.name}' dropper").reload()


def _hold(vehicle: Any, **on: bool) -> None:
    vehicle.helm.holds.set(**on)


def _hold_at(vehicle: Any, **targets: float | None) -> None:
    vehicle.helm.holds.aim(**targets)


def _note(vehicle: Any, **values: Any) -> None:
    vehicle.helm.note(**values)


def _set_parameter(sim: Any, name: str, value: Any) -> None:
    sim.parameters[name] = value


def _link_send(sim: Any, sender: str, receiver: str, topic: str, payload: bytes, **how: Any) -> None:
    if sim.link is None:
        raise ValueError("link_send: the scenario has no link")
    sim.link.send(sender, receiver, topic, payload, **how)


def _push_object(sim: Any, **how: Any) -> None:
    item(sim.objects, how.pop("object"), "object").apply_wrench(**how)


def _set_object_winch(sim: Any, **how: Any) -> None:
    item(sim.objects, how.pop("object"), "object").set_winch(**how)


def _cut_object_tether(sim: Any, **how: Any) -> None:
    item(sim.objects, how.pop("object"), "object").cut_tether(**how)


WIND = (Argument("rate_m_s", unit="m/s", default=None), Argument("tension_n", unit="N", default=None))
CUT = Argument("at_m", unit="m", low=0.0)
PUSH = (
    Argument("force_n", "numbers", "N", length=3),
    Argument("torque_nm", "numbers", "N m", length=3, default=(0.0, 0.0, 0.0)),
    Argument("axes", "text", default="body"),
    Argument("duration_s", unit="s", default=None),
)
DOCKING = [
    Command("release", "leave the station, which releases the vehicle", crosses_link=True, service=TRIGGER),
    Command("undock", "leave the station for free water", crosses_link=True, service=TRIGGER),
    Command("dock", "return to the station, from close by", crosses_link=True, service=TRIGGER),
]
SAFETY = [
    Command(
        "override_failsafe", "take the vehicle back from its failsafe", crosses_link=True, service=TRIGGER
    ),
    Command(
        ALL_STOP, "true: stop the thrusters, overriding all commands, until false is sent",
        (Argument("on", "flag", default=True),),
        crosses_link=True, replaces=True, is_vital=True, service=SET_BOOL, is_piloted=False,
    ),
    Command(
        "inject_fault", "make a component fail", (Argument("kind", "text"),),
        lambda sim, kind, **values: sim.faults.inject(kind, **values),
        of="simulator", notes_itself=True, takes_more=True, changes_world=True,
    ),
    Command(
        "end_fault", "end a fault permanently", (Argument("name", "text"),), lambda sim, name: sim.faults.end(name),
        of="simulator", notes_itself=True, changes_world=True,
    ),
]  # fmt: skip
STEERING = [
    Command(
        "set_effort", "efforts along and about the body axes, held until the next command",
        tuple(Argument(axis, low=-1.0, high=1.0, default=0.0) for axis in AXES),
        crosses_link=True, replaces=True, steers=True, is_piloted=False,
    ),
    Command(
        "set_wrench", "force and torque of the thrusters in still water, body axes",
        (
            Argument("force_body_n", "numbers", "N", length=3),
            Argument("torque_body_nm", "numbers", "N m", length=3, default=(0.0, 0.0, 0.0)),
        ),
        crosses_link=True, replaces=True, steers=True, service="uwsim_msgs/srv/SetWrench", is_piloted=False,
    ),
    Command(
        "set_thrusters", "commands of thrusters by name; the others stop",
        (Argument("commands", "numbers by name", low=-1.0, high=1.0),),
        crosses_link=True, replaces=True, steers=True, service="uwsim_msgs/srv/SetThrusters", is_piloted=False,
    ),
    Command(
        "set_fins", "deflections of fins by name; the others return to 0",
        (Argument("angles_rad", "numbers by name", "rad", -RIGHT_ANGLE_RAD, RIGHT_ANGLE_RAD),),
        crosses_link=True, replaces=True, steers=True, service="uwsim_msgs/srv/SetFins", is_piloted=False,
    ),
    Command(
        "hold", "replace the set of active holds: heading, depth or altitude, position or speed",
        tuple(Argument(name, "flag", default=False) for name in HOLDS), _hold,
        crosses_link=True, replaces=True, steers=True, service="uwsim_msgs/srv/Hold",
    ),
    Command(
        "hold_at", "give the active heading or depth hold a target",
        (Argument("heading_rad", unit="rad", default=None), Argument("z_world_m", unit="m", default=None)), _hold_at,
        crosses_link=True, replaces=True, steers=True,
    ),
    Command(
        "place", "put a vehicle at a pose",
        (
            Argument("position_world_m", "numbers", "m", length=3),
            Argument("orientation_xyzw", "numbers", length=4, default=(0.0, 0.0, 0.0, 1.0)),
            Argument("velocity_body", "numbers", "m/s, rad/s", length=6, default=(0.0,) * 6),
        ),
        is_piloted=False, changes_world=True,
    ),
    Command(
        "set_winch", "pay out a tether at a rate, or keep a tension; without either, hold", WIND, is_ashore=True,
    ),
    Command(
        "cut_tether", "cut a vehicle's tether at this length from its anchor", (CUT,),
        is_piloted=False, changes_world=True,
    ),
    Command(
        "set_object_winch", "command the winch of a loose body's tether like set_winch",
        (Argument("object", "text"), *WIND), _set_object_winch, of="simulator", notes_itself=True,
        is_piloted=False, changes_world=True,
    ),
    Command(
        "cut_object_tether", "cut a loose body's tether like cut_tether", (Argument("object", "text"), CUT),
        _cut_object_tether, of="simulator", notes_itself=True, is_piloted=False, changes_world=True,
    ),
    Command(
        "apply_wrench", "push a vehicle from outside, at its origin, for a while or until the next such command",
        PUSH, service="uwsim_msgs/srv/ApplyWrench", is_piloted=False, changes_world=True,
    ),
    Command(
        "push_object", "push a loose body like apply_wrench", (Argument("object", "text"), *PUSH),
        _push_object, of="simulator", notes_itself=True,
        service="uwsim_msgs/srv/PushObject", is_piloted=False, changes_world=True,
    ),
]  # fmt: skip
ARM = [
    Command(
        "set_joints", "positions, speeds or motor torques of an arm's joints by name; the others keep their commands",
        (
            Argument("positions", "numbers by name", "rad or m", default=None),
            Argument("speeds", "numbers by name", "rad/s or m/s", default=None),
            Argument("torques", "numbers by name", "N m or N", default=None),
        ),
        crosses_link=True,
    ),
]  # fmt: skip
DROPPERS = [
    Command(
        "drop", "let go of the next body in a dropper, by default the first that holds any",
        (Argument("dropper", "text", default=None),), _drop,
        notes_itself=True, crosses_link=True,
    ),
    Command(
        "reload", "fill a dropper with all of its bodies again", (Argument("dropper", "text"),), _reload,
        notes_itself=True, is_piloted=False, changes_world=True,
    ),
]  # fmt: skip
INSTRUMENTS = [
    Command(
        "start_navigation", "start a vehicle's estimator, unless it is running for this use or a higher one",
        (Argument("use", "text", default="steering"),),
    ),
    Command(
        "aim", "tilt a sonar's head, by default the first sonar's; positive: up",
        (
            Argument("elevation_rad", unit="rad", low=-RIGHT_ANGLE_RAD, high=RIGHT_ANGLE_RAD),
            Argument("sonar", "text", default=None),
        ),
        _aim, notes_itself=True, crosses_link=True, replaces=True,
    ),
    Command(
        "set_lamp", "switch the lamps", (Argument("lamp", "text"), Argument("on", "flag")), _set_lamp,
        notes_itself=True, crosses_link=True,
    ),
    Command(
        "aim_camera", "turn a vehicle's camera, or one of the station's if no vehicle is named",
        (
            Argument("camera", "text"),
            Argument("pan_rad", unit="rad", default=None),
            Argument("tilt_rad", unit="rad", default=None),
        ),
        _aim_camera, of="either", notes_itself=True, crosses_link=True,
    ),
    Command(
        "set_optics", "change the light", (), lambda sim, **changes: sim.set_optics(**changes),
        of="simulator", notes_itself=True, takes_more=True, changes_world=True,
    ),
]  # fmt: skip
PARAMETERS = [
    Command(
        "set_parameter", "set a parameter", (Argument("name", "text"), Argument("value", "any")), _set_parameter,
        of="simulator", notes_itself=True, changes_world=True,
    ),
    Command(
        "set_parameters", "set several parameters at once", (Argument("changes", "any"),),
        lambda sim, changes: sim.parameters.update(changes), of="simulator", notes_itself=True, changes_world=True,
    ),
    Command(
        "reset_parameters", "restore the scenario's value of one parameter, of all below a name, or of all",
        (Argument("name", "text", default=None),), lambda sim, name=None: sim.parameters.reset(name),
        of="simulator", notes_itself=True, changes_world=True,
    ),
]  # fmt: skip
ASHORE = [
    Command(
        NOTE, "write a note to the run's log, with its position as estimated by the vehicle",
        (
            Argument("text", "text"),
            Argument("category", "text", default="observation"),
            Argument("position_world_m", "numbers", "m", length=3, default=None),
            Argument("picture", "text", default=""),
        ),
        _note, is_piloted=False, is_ashore=True,
    ),
]  # fmt: skip
AUTOPILOT = [
    Command(
        SERVO_FRAMES, "an autopilot's servo outputs, 32 uint16 [us] per step, starting at a tick",
        (
            Argument("vehicle", "text"),
            Argument("frame", "text"),
            Argument("from_tick", low=0),
            Argument("frames", "bytes"),
        ),
        lambda sim, **arguments: sim.lockstep.play(sim, **arguments), of="simulator", is_piloted=False,
    ),
]  # fmt: skip
LINK = [
    Command(
        "link_send", "submit a message to the link",
        (
            Argument("sender", "text"),
            Argument("receiver", "text"),
            Argument("topic", "text"),
            Argument("payload", "bytes"),
            Argument("priority", low=0, high=255, default=0),
            Argument("lifetime_s", unit="s", low=0.0, high=1e9, default=None),
            Argument("replaces", "flag", default=False),
            Argument("repeats", low=0, high=10, default=0),
        ),
        _link_send, of="simulator", notes_itself=True, is_piloted=False,
    ),
]  # fmt: skip

COMMANDS: dict[str, Command] = {
    command.name: command
    for command in (
        *DOCKING,
        *SAFETY,
        *STEERING,
        *ARM,
        *DROPPERS,
        *AUTOPILOT,
        *INSTRUMENTS,
        *PARAMETERS,
        *ASHORE,
        *LINK,
    )
}
"""All commands by name, except `reset` and `restore_state`, which belong to the simulator itself."""


def command_named(name: str) -> Command:
    """Look up a command by name. Raises ValueError, listing the known names."""
    if name not in COMMANDS:
        raise ValueError(f"command = {name!r}: must be one of {', '.join(COMMANDS)}")
    return COMMANDS[name]


def bound_command(name: str, arguments: Mapping[str, Any]) -> Callable[[Any], Any]:
    """Return a function that applies a command, with these arguments, to a simulator. Raises ValueError."""
    return command_named(name).bound(arguments)
