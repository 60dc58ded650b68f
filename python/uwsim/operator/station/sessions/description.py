"""The description of a running simulator for the page: its vehicles, views, tethers and what pilots may do."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from uwsim.base.axes import AXES
from uwsim.channels.families.body_frames import body_frames
from uwsim.channels.families.imaging import picture_geometry
from uwsim.channels.families.tether import object_topic
from uwsim.channels.guest import Values
from uwsim.channels.source import Source
from uwsim.operator.station.scene.loose_objects import TOPIC as OBJECTS
from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.views.views import View, title
from uwsim.scenario.spec.imaging_sonar import core_kind
from uwsim.scenario.spec.tether import Tether
from uwsim.simulator.vehicle import Vehicle


def describe(running: Running) -> Values:
    """Return the response of `/station/describe`, except the session."""
    sim = running.live.simulator
    scenario, optional = sim.parameters.scenario, {channel.name for channel in running.table.channels}
    return {
        "scenario": scenario.name,
        "description": " ".join(scenario.description.split()),
        "step_s": sim.step_s,
        "mission_time_s": scenario.mission_time_s,
        "seed": sim.seed,
        "truth_allowed": running.truth,
        "warnings": {
            "range_m": scenario.warnings.range_m,
            "proximity_m": scenario.warnings.proximity_m,
            "as_published": scenario.wire == "published",
        },
        "vehicles": [_vehicle(running, source, optional) for source in running.table.sources],
        "views": [_camera_view(running, view) for view in running.views.views.values()] + _sonar_views(running),
        "scene": "/scene/scene.json",
        "tethers": {
            one.name: found
            for one in scenario.tethered
            if one.name in sim.objects
            and (found := _tether(running, one.tether, _offered(partial(object_topic, one.name), optional)))
        },
        "objects": f"/{OBJECTS}" if running.objects is not None and running.objects.topics() else None,
        "life": running.life.described() if running.life is not None else None,
        "commands": running.commands(),
        "is_recorded": running.flight is not None,
        "has_exercise": running.judged is not None,
        "has_survey": scenario.survey is not None,
        "replay": None if running.replay is None else running.replay.describe(),
        "branched_from": running.branched_from,
    }


def _camera_view(running: Running, view: View) -> Values:
    described = view.described()
    if running.arrivals is None or view.name not in running.arrivals:
        return described
    aboard = (
        {"aboard_topic": described["topic"], "aboard_small_topic": described["small_topic"]} if running.truth else {}
    )
    topics = {"topic": f"/station/view/{view.name}", "small_topic": f"/station/small/{view.name}"}
    return {**described, **topics, **aboard, **running.arrivals.describe(view.name)}


def _sonar_views(running: Running) -> list[Values]:
    """Return the views of imaging sonars, which are ordinary channels paced by simulated time."""
    arrivals = running.arrivals
    return [
        {
            "name": source.topic(name), "title": title(source.topic(name)), "kind": core_kind(type(sonar.model)),
            "vehicle": source.name, "frame_id": source.frame(f"{name}_link"), "width": 0, "height": 0,
            "topic": f"/{source.topic(name)}/picture/compressed",
            "small_topic": f"/{source.topic(name)}/picture/compressed",
            "sonar": picture_geometry(sonar.model),
            **({} if arrivals is None else {"link": arrivals.pace(f"{source.topic(name)}/picture/compressed")}),
        }
        for source in running.table.sources
        for name, sonar in source.of(running.live.simulator).imaging_sonars.items()
    ]  # fmt: skip


def _vehicle(running: Running, source: Source, optional: set[str]) -> Values:
    vehicle = source.of(running.live.simulator)

    topic = _offered(source.topic, optional)
    has_map = source.name in running.maps
    tilt = sonar = None
    if vehicle.sonars:
        model = vehicle.sonar.model
        rate_rad_s = model.tilt_rate_rad_s
        tilt = {"min_rad": -0.5 * math.pi, "max_rad": 0.5 * math.pi, "rate_rad_s": rate_rad_s}
        sonar = {
            "name": model.name, "title": source.entry.sonar.title, "range_m": model.range_max_m,
            "beams": model.beams, "fov_rad": model.field_of_view_rad,
        }  # fmt: skip
    motors = [
        {"camera": name, "pan_deg": list(motor.pan_limits_deg), "tilt_deg": list(motor.tilt_limits_deg)}
        for name, camera in vehicle.cameras.items()
        if (motor := camera.mount.pan_tilt) is not None
    ]
    return {
        "name": source.name,
        "model": source.entry.model.name,
        "prefix": source.prefix,
        "telemetry": topic("telemetry"),
        "sensor_gauges": topic("sensor_gauges"),
        "scan": topic("ping"),
        "joints": topic("joint_states"),
        "proximities": [
            {"name": name.removeprefix("proximity_"), "topic": found}
            for name, sensor in vehicle.sensors.items()
            if sensor.kind == "proximity" and (found := topic(name))
        ],
        "link": topic("link"),
        "map": f"/map/{source.name}" if has_map else None,
        "map_changes": topic("map_changes"),
        "pings_per_s": running.table.pings[source.name].rate_hz if has_map else 0.0,
        "thrusters": list(vehicle.thrusters),
        "lamps": list(vehicle.lamps),
        "droppers": list(vehicle.droppers),
        "efforts": [axis for axis in AXES if axis in vehicle.controllable],
        "holds": vehicle.holds.possible if vehicle.holds is not None else [],
        "tilt": tilt,
        "sonar": sonar,
        "motors": motors,
        "tether": _tether(running, source.entry.tether, topic),
        "arm": _arm(source, vehicle),
        "can_jog": vehicle.arm is not None and vehicle.arm.can_jog,
    }


def _tether(running: Running, spec: Tether | None, topic: Callable[[str], str | None]) -> Values | None:
    shape, tension = topic("tether/shape"), topic("tether/tension")
    if spec is None or shape is None or tension is None:
        return None
    winch = spec.winch
    return {
        "shape": shape, "tension": tension, "turns": topic("tether/turns"),
        "origin_m": np.asarray(running.table.origin_m, float).tolist(), "breaking_load_n": spec.breaking_load_n,
        "fastest_m_s": None if winch is None else winch.fastest_m_s,
        "strongest_n": None if winch is None else winch.strongest_n,
    }  # fmt: skip


def _offered(full: Callable[[str], str], optional: set[str]) -> Callable[[str], str | None]:
    """Return what finds a topic's name for pages; None where it is not offered."""
    return lambda name: f"/{full(name)}" if full(name) in optional else None


def _arm(source: Source, vehicle: Vehicle) -> list[Values]:
    """Return the joints with motors, and their stops; a hinge without any turns half a turn to either side."""
    if vehicle.arm is None:
        return []
    joints = {frame.joint.name: frame.joint for frame in body_frames(source.entry.model) if frame.joint is not None}
    return [
        {
            "name": name,
            "low": joint.low_rad if math.isfinite(joint.low_rad) else -math.pi,
            "high": joint.high_rad if math.isfinite(joint.high_rad) else math.pi,
            "is_slide": joint.is_slide,
            "is_jaw": name in vehicle.arm.jaws,
        }
        for name in vehicle.arm.motors
        for joint in [joints[name]]
    ]
