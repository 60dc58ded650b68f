"""A simulator run by the station: its channels, views and map, and its description for the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from uwsim.base.axes import AXES
from uwsim.base.commands import COMMANDS
from uwsim.bridges.rosbridge.client import RosbridgeClient
from uwsim.channels.authority.rights import OF_INSTRUCTOR, AidKind
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.families.body_frames import body_frames
from uwsim.channels.families.imaging import picture_geometry
from uwsim.channels.families.map import PLACED
from uwsim.channels.families.tether import object_topic
from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.served import served_table
from uwsim.channels.source import Source
from uwsim.channels.table import Wire
from uwsim.link import Carrier
from uwsim.link.ashore import with_scans
from uwsim.live import LiveSimulator
from uwsim.operator.station.flights.flights import FlightRecording
from uwsim.operator.station.flights.replay import Replay
from uwsim.operator.station.helm.pilot import Pilot
from uwsim.operator.station.helm.plan import PlanFlight
from uwsim.operator.station.scene.life import Life
from uwsim.operator.station.scene.loose_objects import TOPIC as OBJECTS
from uwsim.operator.station.scene.loose_objects import LooseObjects
from uwsim.operator.station.scene.scene import Scene
from uwsim.operator.station.sessions.exercise import Judged
from uwsim.operator.station.sessions.inspection import Inspection
from uwsim.operator.station.start.prepared import load_navigation
from uwsim.operator.station.start.user_rosbridge import UserRosbridge
from uwsim.operator.station.views.arrivals import Arrivals
from uwsim.operator.station.views.snapshots import Snapshots
from uwsim.operator.station.views.views import View, Views, title
from uwsim.recording import Recorder
from uwsim.scenario.spec.imaging_kind import core_kind
from uwsim.scenario.spec.tether import Tether
from uwsim.simulator.vehicle import Vehicle

SHOWN = ("telemetry", PLACED, "image_raw/compressed", "picture/compressed")
"""Name endings of the channels that the page shows: a modem, with its low capacity, carries only these by default."""


def piloted_commands() -> list[str]:
    """Return the commands that a pilot may issue by name, in addition to the services `drive` and `all_stop`."""
    return sorted(name for name, command in COMMANDS.items() if command.is_piloted)


@dataclass
class Moment:
    """A saved moment. course: the state of the exercise, if there is one."""

    name: str
    time_s: float
    state: bytes
    course: object = None


class Running:
    """A live simulator, from `start` to `stop`.

    The map is built from the start, so that late visitors see all of it. wake: called when a picture may be due. truth:
    whether the true position may be shown. folder: where notes are written. edition: a number that increases when a
    change of a parameter changes the result of `describe`; see `notice_changes`. replay: the replay that the simulator
    follows, if any. In a replay, the truth is shown, and all values are those aboard, without a link. branched_from:
    the point in a replay at which a pilot took the helm, or "". instruction: the instructor's last message, or "".
    """

    def __init__(
        self,
        live: LiveSimulator,
        node: Node,
        wake: Callable[[], object],
        *,
        wire: Wire,
        origin: str | Sequence[float],
        truth: bool,
        feed: Feed | None = None,
        folder: Path | None = None,
        replay: Replay | None = None,
    ) -> None:
        sim = live.simulator
        self.live = live
        self.feed = feed or Feed(live)
        self.replay = replay
        self.truth = truth = truth or replay is not None
        self.table = table = served_table(live, wire=wire, origin=origin, truth=truth, waits_at_full_speed=False)
        over_modem = sim.link is not None and sim.link.modem.kind == "modem"
        has_carrier = sim.link is not None and replay is None  # a replay shows the values aboard, and sends nothing
        self.carrier = Carrier(live, table, only=SHOWN if over_modem else None) if has_carrier else None
        self.maps = self.table.maps  # over a link, those built ashore
        self.far = live if self.carrier is None else self.carrier.remote()  # the simulator as commanded by pilots
        if self.carrier is not None:
            table.channels, table.services = with_scans(self.carrier.channels), self.carrier.over(table.services)
        self.pilot = Pilot(self.far, self.table.steering)
        self.scene = Scene(sim, self.table.sources)
        self.objects: LooseObjects | None = None  # without the truth, a pilot does not know where they are
        self.life: Life | None = None
        if truth:
            self.objects = LooseObjects(live, node, table.sources[0].origin_m)
            self.life = Life(live, node, table.sources[0].origin_m)
        self.views = Views(live, self.table, node, wake, over_link=has_carrier, truth=truth)
        self.arrivals: Arrivals | None = None
        if self.carrier is not None:
            self.arrivals = Arrivals(live, self.carrier, self.views.views.values(), node)
        self.recorder: Recorder | None = None
        self.flight: FlightRecording | None = None
        self.branched_from = ""
        self.instruction = ""
        self.judged: Judged | None = None
        self.plan: PlanFlight | None = None
        self.is_supervised = False
        self.rosbridge: RosbridgeClient | None = None
        self.edition = 0
        self._described = sim.parameters.scenario
        self.moments: list[Moment] = []
        self.snapshots = Snapshots(live, table, self.views, self.arrivals)
        self.inspection = Inspection(self.snapshots, lambda: self.recorder, folder or Path.cwd())

    @property
    def driver(self) -> str:
        """The kind of client, other than the pilot, whose command is in effect, or ""."""
        return next((name for each in self.table.steering.values() if (name := each.driver)), "")

    def aids_in_use(self) -> set[AidKind]:
        """Return those of a pilot's aids in use that the vehicle itself does not know."""
        found: set[AidKind] = {"autopilot"} if self.plan is not None and self.plan.is_on else set()
        is_flown = self.driver or any(each.is_flown for each in self.table.steering.values())
        return found | ({"program"} if is_flown else set())

    def start(self) -> None:
        """Start stepping the simulator and building the map."""
        if self.replay is not None:
            self.replay.start()
        load_navigation()
        if not self.live.running:
            self.live.start()
        if self.carrier is not None:
            self.carrier.start()
        if self.arrivals is not None:
            self.arrivals.start()
        for name, ping_map in self.maps.items():
            offered = [each for each in self.table.channels if each.read == ping_map.read_changes]
            for channel in offered:  # through the feed, which gives the whole map to a page that subscribes later
                self.feed.listen(channel, lambda reading: None)
            if not offered:
                rate_hz = self.table.pings[name].rate_hz
                self.live.every(1.0 / rate_hz, ping_map.read_changes, lambda message: None)
        if self.objects is not None:
            self.objects.start()
        if self.life is not None:
            self.life.start()
        if self.judged is not None:
            self.judged.start()
        if self.flight is not None:
            self.flight.start()

    def hide_the_simulation(self) -> None:
        """Hide what shows the world from clients, and refuse what changes it, by whatever door."""
        self.table.rights.close_world(self.live, OF_INSTRUCTOR)
        self.table.services = [each for each in self.table.services if not each.name.startswith("simulation/")]
        self.is_supervised = True

    def join(self, rosbridge: UserRosbridge) -> None:
        """Join the user's rosbridge with the topics of the paper's simulator, as `uwsim connect` does."""
        table = self.table
        sent = [each for each in table.channels if each.name in table.published and not each.delivery.on_request]
        self.rosbridge = RosbridgeClient(
            self.live, rosbridge.url, channels=sent, services=table.services, ros=rosbridge.ros, feed=self.feed
        ).start()

    def notice_changes(self) -> None:
        """Increment the edition if a parameter has changed since the last call."""
        scenario = self.live.simulator.parameters.scenario
        if scenario is not self._described:
            self._described = scenario
            self.edition += 1
            self.views.renew()

    def stop(self) -> None:
        """Finish the recordings, and stop stepping."""
        if self.flight is not None:
            self.flight.stop()
        self.stop_recording()
        if self.rosbridge is not None:
            self.rosbridge.close()
        self.end_plan("the simulator was stopped")
        if self.judged is not None:
            self.judged.stop()
        if self.carrier is not None:
            self.carrier.close()
        self.live.stop()

    @property
    def recording(self) -> str:
        """The name of the file that is being recorded on request, or "" if there is none or it cannot be written."""
        recorder = self.recorder
        return "" if recorder is None or recorder.error is not None else recorder.path.name

    def record(self, path: Path) -> None:
        """Start a light recording, without pictures and maps. Raises ValueError or OSError."""
        if self.recorder is not None:
            raise ValueError(f"{self.recorder.path.name} is being recorded already")
        self.recorder = Recorder(self.live, path, shared=self.table, feed=self.feed, is_light=True).start()

    def stop_recording(self) -> Path | None:
        """Finish the recording and return its path, or None if nothing is being recorded. Raises OSError."""
        recorder, self.recorder = self.recorder, None
        if recorder is None:
            return None
        recorder.close()
        return recorder.path

    def describe(self) -> Values:
        """Return the response of `/station/describe`, except the session."""
        sim = self.live.simulator
        scenario, optional = sim.parameters.scenario, {channel.name for channel in self.table.channels}
        return {
            "scenario": scenario.name,
            "description": " ".join(scenario.description.split()),
            "step_s": sim.step_s,
            "mission_time_s": scenario.mission_time_s,
            "seed": sim.seed,
            "truth_allowed": self.truth,
            "warnings": {"range_m": scenario.warnings.range_m, "proximity_m": scenario.warnings.proximity_m},
            "vehicles": [self._vehicle(source, optional) for source in self.table.sources],
            "views": [self._camera_view(view) for view in self.views.views.values()] + self._sonar_views(),
            "scene": "/scene/scene.json",
            "tethers": {
                one.name: found
                for one in scenario.tethered
                if one.name in sim.objects
                and (found := self._tether(one.tether, _offered(partial(object_topic, one.name), optional)))
            },
            "objects": f"/{OBJECTS}" if self.objects is not None and self.objects.topics() else None,
            "life": self.life.described() if self.life is not None else None,
            "commands": self.commands(),
            "is_supervised": self.is_supervised,
            "is_recorded": self.flight is not None,
            "has_exercise": self.judged is not None,
            "replay": None if self.replay is None else self.replay.describe(),
            "branched_from": self.branched_from,
        }

    def end_plan(self, because: str) -> None:
        """End the plan being flown, if any."""
        if self.plan is not None:
            self.plan.stop(because)

    def commands(self) -> list[str]:
        """Return the commands that a pilot may issue by name.

        With an instructor or in an exercise, only those to a vehicle are included.
        """
        is_closed = self.is_supervised or self.judged is not None
        return [name for name in piloted_commands() if not is_closed or COMMANDS[name].crosses_link]

    def topics(self) -> list[GuestTopic]:
        """Return the topics of all views."""
        guests = [each for each in (self.views, self.arrivals, self.objects, self.life) if each is not None]
        return [topic for each in guests for topic in each.topics()]

    def _camera_view(self, view: View) -> Values:
        described = view.described()
        if self.arrivals is None or view.name not in self.arrivals:
            return described
        aboard = (
            {"aboard_topic": described["topic"], "aboard_small_topic": described["small_topic"]} if self.truth else {}
        )
        topics = {"topic": f"/station/view/{view.name}", "small_topic": f"/station/small/{view.name}"}
        return {**described, **topics, **aboard, **self.arrivals.describe(view.name)}

    def _sonar_views(self) -> list[Values]:
        """Return the views of imaging sonars, which are ordinary channels paced by simulated time."""
        return [
            {
                "name": source.topic(name), "title": title(source.topic(name)), "kind": core_kind(type(sonar.model)),
                "vehicle": source.name, "frame_id": source.frame(f"{name}_link"), "width": 0, "height": 0,
                "topic": f"/{source.topic(name)}/picture/compressed",
                "small_topic": f"/{source.topic(name)}/picture/compressed",
                "sonar": picture_geometry(sonar.model),
                **self._sonar_link(f"{source.topic(name)}/picture/compressed"),
            }
            for source in self.table.sources
            for name, sonar in source.of(self.live.simulator).imaging_sonars.items()
        ]  # fmt: skip

    def _sonar_link(self, channel: str) -> Values:
        return {} if self.arrivals is None else {"link": self.arrivals.pace(channel)}

    def _vehicle(self, source: Source, optional: set[str]) -> Values:
        vehicle = source.of(self.live.simulator)

        topic = _offered(source.topic, optional)
        has_map = source.name in self.maps
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
            "pings_per_s": self.table.pings[source.name].rate_hz if has_map else 0.0,
            "thrusters": list(vehicle.thrusters),
            "lamps": list(vehicle.lamps),
            "efforts": [axis for axis in AXES if axis in vehicle.controllable],
            "holds": vehicle.holds.possible if vehicle.holds is not None else [],
            "tilt": tilt,
            "sonar": sonar,
            "motors": motors,
            "tether": self._tether(source.entry.tether, topic),
            "arm": _arm(source, vehicle),
        }

    def _tether(self, spec: Tether | None, topic: Callable[[str], str | None]) -> Values | None:
        shape, tension = topic("tether/shape"), topic("tether/tension")
        if spec is None or shape is None or tension is None:
            return None
        winch = spec.winch
        return {
            "shape": shape, "tension": tension, "turns": topic("tether/turns"),
            "origin_m": np.asarray(self.table.origin_m, float).tolist(), "breaking_load_n": spec.breaking_load_n,
            "fastest_m_s": None if winch is None else winch.fastest_m_s,
            "strongest_n": None if winch is None else winch.strongest_n,
        }  # fmt: skip


def _offered(full: Callable[[str], str], optional: set[str]) -> Callable[[str], str | None]:
    """Return what finds a topic's name for pages; None where it is not offered."""
    return lambda name: f"/{full(name)}" if full(name) in optional else None


def _arm(source: Source, vehicle: Vehicle) -> list[Values]:
    """Return the joints with motors, and their stops; a hinge without any turns half a turn to either side."""
    motors = () if vehicle.arm is None else vehicle.arm.motors
    joints = {frame.joint.name: frame.joint for frame in body_frames(source.entry.model) if frame.joint is not None}
    return [
        {
            "name": name,
            "low": joint.low_rad if math.isfinite(joint.low_rad) else -math.pi,
            "high": joint.high_rad if math.isfinite(joint.high_rad) else math.pi,
            "is_slide": joint.is_slide,
        }
        for name in motors
        for joint in [joints[name]]
    ]
