"""Services of a vehicle and of the simulator itself; each answers {"success": ..., "message": ...}."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from uwsim.channels.channel import Service
from uwsim.channels.map import PingMap
from uwsim.channels.pictures import RATE_HZ, Pictures, Stream
from uwsim.channels.source import Source
from uwsim.channels.steering import require_link
from uwsim.live import LiveSimulator
from uwsim.live.commands import ALL_STOP
from uwsim.simulator import Simulator

SET_STREAM = "set_stream"
"""The name under which a recording knows that a stream of pictures was changed."""
TRIGGER, SET_BOOL = "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"
Request = dict[str, Any]
STEPS_MAX = 1_000_000


def simulation_services() -> list[Service]:
    """Return the services of the simulator itself."""
    return [
        Service("simulation/pause", TRIGGER, _done(lambda live, request: live.pause()), "stand still"),
        Service("simulation/resume", TRIGGER, _done(lambda live, request: live.resume()), "run again"),
        Service("simulation/reset", TRIGGER, _done(lambda live, request: live.reset()), "go to the start"),
        Service(
            "simulation/step", "uwsim_msgs/srv/Step", _done(_step), "make request.steps steps while paused"
        ),
        Service(
            "simulation/set_speed", "uwsim_msgs/srv/SetSpeed", _done(_set_speed),
            'run at request.speed simulated seconds per second; 0 stands for "max"',
        ),
        Service("simulation/pace", "uwsim_msgs/srv/Pace", _pace, "the pace that is asked for, how it is held, step_s"),
    ]  # fmt: skip


def vehicle_services(source: Source, sim: Simulator, pictures: Pictures, maps: Mapping[str, PingMap]) -> list[Service]:
    """Return the services of a vehicle."""
    name, vehicle = source.name, source.of(sim)
    found = [
        Service(source.topic(verb), TRIGGER, _done(_commanded(name, verb)), description)
        for verb, description in (
            ("release", "leave the station, which lets go"),
            ("undock", "leave the station for free water"),
            ("dock", "return to the station, from close by"),
            ("override_failsafe", "take the vehicle back from its failsafe"),
        )
    ]
    found.append(
        Service(
            source.topic("all_stop"), SET_BOOL, _done(_all_stop(name)), is_vital=True,
            description="true: stop the thrusters, against every command, until false releases it",
        )
    )  # fmt: skip
    for lamp in vehicle.lamps:
        found.append(Service(source.topic(f"lights/{lamp}"), SET_BOOL, _done(_lamp(name, lamp)), "switch the lamps"))
    for camera in vehicle.cameras:
        found.append(stream_service(source.topic(f"camera/{camera}"), source.topic(camera), pictures))
    for sonar in vehicle.imaging_sonars:
        found.append(stream_service(source.topic(sonar), source.topic(sonar), pictures))
    if name in maps:
        found.append(
            Service(
                source.topic("save_map"), "uwsim_msgs/srv/SaveMap", _done(_save_map(maps, name)),
                "write the map to request.name, a .bt file in the folder where the simulator was started or below",
            )
        )  # fmt: skip
    return found


def _commanded(vehicle: str, command: str) -> Callable[[LiveSimulator, Request], object]:
    def call(live: LiveSimulator, request: Request) -> object:
        require_link(live, vehicle, command)
        return live.command(command, vehicle=vehicle).result()

    return call


def stream_service(topic: str, key: str, pictures: Pictures) -> Service:
    """Return the service that sets how the pictures of a camera or an imaging sonar are sent."""
    return Service(
        f"{topic}/set_stream", "uwsim_msgs/srv/SetStream", _done(_set_stream(key, pictures)),
        f"set enabled, rate_hz (at most {RATE_HZ:g}), width [pixels, 0: its own] and JPEG quality; "
        "what is not given stays",
    )  # fmt: skip


def _done(act: Callable[[LiveSimulator, Request], object]) -> Callable[[LiveSimulator, Request], Request]:
    """Return a service that acts and says whether it could."""

    def call(live: LiveSimulator, request: Request) -> Request:
        try:
            message = act(live, request)
        except (ValueError, OSError) as error:
            return {"success": False, "message": str(error)}
        return {"success": True, "message": message if isinstance(message, str) else ""}

    return call


def _all_stop(vehicle: str) -> Callable[[LiveSimulator, Request], object]:
    def call(live: LiveSimulator, request: Request) -> object:
        on = _field(request, "data", bool, None)
        require_link(live, vehicle, ALL_STOP)
        return live.command(ALL_STOP, vehicle=vehicle, on=on).result()

    return call


def _lamp(vehicle: str, lamp: str) -> Callable[[LiveSimulator, Request], object]:
    def switch(live: LiveSimulator, request: Request) -> object:
        on = _field(request, "data", bool, None)
        require_link(live, vehicle, "set_lamp")
        return live.command("set_lamp", vehicle=vehicle, lamp=lamp, on=on).result()

    return switch


def _step(live: LiveSimulator, request: Request) -> None:
    steps = _field(request, "steps", int, 1)
    if not 0 <= steps <= STEPS_MAX:
        raise ValueError(f"steps = {steps}: must be in [0, {STEPS_MAX}]")
    live.step(steps)


def _set_speed(live: LiveSimulator, request: Request) -> None:
    live.speed = _field(request, "speed", float, None) or "max"


def _pace(live: LiveSimulator, request: Request) -> Request:
    return {
        "speed": 0.0 if live.speed == "max" else live.speed,
        "factor": live.factor,
        "lateness_s": live.lateness,
        "slipped_s": live.slipped_s,
        "paused": live.paused,
        "error": str(live.error or ""),
        "step_s": live.simulator.step_s,
    }


def _save_map(maps: Mapping[str, PingMap], vehicle: str) -> Callable[[LiveSimulator, Request], str]:
    def save(live: LiveSimulator, request: Request) -> str:
        name: str = _field(request, "name", str, "map.bt")
        if vehicle not in maps:
            raise ValueError(f"there is no map of '{vehicle}': the link carries no pings for it, see link.carries")
        maps[vehicle].write(_checked_path(name))
        return name

    return save


def _checked_path(name: str) -> Path:
    """Return the path of a .bt file in the working folder or one below it that exists. Raises ValueError."""
    folder = Path.cwd().resolve()
    path = (folder / name).resolve() if "\0" not in name else folder  # links are followed before the check
    hidden = any(part.startswith(".") for part in path.parts[len(folder.parts) :])
    if path.suffix != ".bt" or not path.is_relative_to(folder) or hidden:
        raise ValueError(f"name = {name!r}: must be a .bt file in '{folder}' or a folder in it, not hidden")
    if not path.parent.is_dir():
        raise ValueError(f"name = {name!r}: the folder '{path.parent}' does not exist")
    return path


def _set_stream(key: str, pictures: Pictures) -> Callable[[LiveSimulator, Request], None]:
    def set_stream(live: LiveSimulator, request: Request) -> None:
        stream = pictures.stream(key)
        enabled = _field(request, "enabled", bool, stream.enabled)
        rate_hz = _field(request, "rate_hz", float, stream.rate_hz)
        width, quality = _field(request, "width", int, stream.width), _field(request, "quality", int, stream.quality)
        chosen = Stream(enabled, rate_hz, width, quality)

        def change(sim: Simulator) -> None:
            pictures.set_stream(key, chosen)
            sim.journal.note(SET_STREAM, key=key, **asdict(chosen))

        if live.running:
            live.read(change).result()  # between two steps, as a replay does it
        else:
            change(live.simulator)

    return set_stream


def _field(request: Request, name: str, kind: type, default: Any) -> Any:
    """Return a field of a request, checked. Raises ValueError."""
    value = request.get(name, default)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if kind is int and isinstance(value, float) and value.is_integer():
        value = int(value)  # JavaScript knows only floats
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise ValueError(f"{name} = {value!r}: must be given, as {kind.__name__}")
    return value
