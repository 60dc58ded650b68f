"""Services of vehicles and of the simulator. Most respond with {"success": ..., "message": ...}."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path

from uwsim.base.commands import SET_BOOL, TRIGGER
from uwsim.channels.authority.steering import Steering, require_link
from uwsim.channels.calls.command_services import command_services
from uwsim.channels.channel import Service
from uwsim.channels.delivery.pictures import RATE_HZ, Pictures, Stream
from uwsim.channels.families.map import PingMap
from uwsim.channels.request import Request, answered, field
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

SET_STREAM = "set_stream"
"""The name under which recordings store changes to picture streams."""
STEPS_MAX = 1_000_000


def simulation_services() -> list[Service]:
    """Return the services of the simulator."""
    return [
        Service("simulation/pause", TRIGGER, answered(lambda live, request: live.pause()), "stand still"),
        Service("simulation/resume", TRIGGER, answered(lambda live, request: live.resume()), "run again"),
        Service("simulation/reset", TRIGGER, answered(lambda live, request: live.reset()), "go to the start"),
        Service("simulation/step", "uwsim_msgs/srv/Step", answered(_step), "make request.steps steps while paused"),
        Service(
            "simulation/set_speed",
            "uwsim_msgs/srv/SetSpeed",
            answered(_set_speed),
            'run at request.speed simulated seconds per second; 0 stands for "max"',
        ),
        Service("simulation/pace", "uwsim_msgs/srv/Pace", _pace, "requested pace, how well it is kept, step_s"),
    ]


def vehicle_services(
    source: Source, sim: Simulator, pictures: Pictures, maps: Mapping[str, PingMap], steering: Steering
) -> list[Service]:
    """Return the services of a vehicle."""
    name, vehicle = source.name, source.of(sim)
    found = command_services(source, steering)
    for lamp in vehicle.lamps:
        found.append(
            Service(
                source.topic(f"lights/{lamp}"), SET_BOOL, answered(_lamp(name, lamp)), "switch the lamps",
                permit=steering.rights.require,
            )
        )  # fmt: skip
    for camera in vehicle.cameras:
        found.append(stream_service(source.topic(f"camera/{camera}"), source.topic(camera), pictures))
    for sonar in vehicle.imaging_sonars:
        found.append(stream_service(source.topic(sonar), source.topic(sonar), pictures))
    if name in maps:
        found.append(
            Service(
                source.topic("save_map"), "uwsim_msgs/srv/SaveMap", answered(_save_map(maps, name)),
                "write the map to request.name, a .bt file in the folder where the simulator was started or below",
            )
        )  # fmt: skip
    return found


def stream_service(topic: str, key: str, pictures: Pictures) -> Service:
    """Return the service that configures the picture stream of a camera or imaging sonar."""
    return Service(
        f"{topic}/set_stream", "uwsim_msgs/srv/SetStream", answered(_set_stream(key, pictures)),
        f"set enabled, rate_hz (at most {RATE_HZ:g}), width [pixels, 0: its own] and JPEG quality; "
        "what is not given stays",
    )  # fmt: skip


def _lamp(vehicle: str, lamp: str) -> Callable[[LiveSimulator, Request], object]:
    def switch(live: LiveSimulator, request: Request) -> object:
        on = field(request, "data", bool, None)
        require_link(live, vehicle, "set_lamp")
        return live.command("set_lamp", vehicle=vehicle, lamp=lamp, on=on).result()

    return switch


def _step(live: LiveSimulator, request: Request) -> None:
    steps = field(request, "steps", int, 1)
    if not 0 <= steps <= STEPS_MAX:
        raise ValueError(f"steps = {steps}: must be in [0, {STEPS_MAX}]")
    live.step(steps)


def _set_speed(live: LiveSimulator, request: Request) -> None:
    live.speed = field(request, "speed", float, None) or "max"


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
        name: str = field(request, "name", str, "map.bt")
        if vehicle not in maps:
            raise ValueError(f"there is no map of '{vehicle}': the link carries no pings for it, see link.carries")
        maps[vehicle].write(_checked_path(name))
        return name

    return save


def _checked_path(name: str) -> Path:
    """Return the path to a .bt file in the working folder or an existing subfolder. Raises ValueError."""
    folder = Path.cwd().resolve()
    path = (folder / name).resolve() if "\0" not in name else folder  # symbolic links are followed before the check
    hidden = any(part.startswith(".") for part in path.parts[len(folder.parts) :])
    if path.suffix != ".bt" or not path.is_relative_to(folder) or hidden:
        raise ValueError(f"name = {name!r}: must be a .bt file in '{folder}' or a folder in it, not hidden")
    if not path.parent.is_dir():
        raise ValueError(f"name = {name!r}: the folder '{path.parent}' does not exist")
    return path


def _set_stream(key: str, pictures: Pictures) -> Callable[[LiveSimulator, Request], None]:
    def set_stream(live: LiveSimulator, request: Request) -> None:
        stream = pictures.stream(key)
        enabled = field(request, "enabled", bool, stream.enabled)
        rate_hz = field(request, "rate_hz", float, stream.rate_hz)
        width, quality = field(request, "width", int, stream.width), field(request, "quality", int, stream.quality)
        chosen = Stream(enabled, rate_hz, width, quality)

        def change(sim: Simulator) -> None:
            pictures.set_stream(key, chosen)
            sim.journal.note(SET_STREAM, key=key, **asdict(chosen))

        if live.running:
            live.read(change).result()  # between two steps, as in a replay
        else:
            change(live.simulator)

    return set_stream
