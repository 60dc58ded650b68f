"""A simulator run by the station: its channels, views and map, and what goes on in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from uwsim.base.commands import COMMANDS
from uwsim.bridges.rosbridge.simulator_client import RosbridgeClient
from uwsim.channels.authority.rights import AidKind
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.families.scans import PLACED
from uwsim.channels.guest import GuestTopic, Node
from uwsim.channels.served import served_table
from uwsim.channels.table import Wire
from uwsim.link import Carrier
from uwsim.link.ashore import with_scans
from uwsim.live import LiveSimulator
from uwsim.operator.station.controls.pilot import Pilot
from uwsim.operator.station.controls.plan import PlanFlight
from uwsim.operator.station.flights.flights import FlightRecording
from uwsim.operator.station.flights.replay import Replay
from uwsim.operator.station.scene.life import Life
from uwsim.operator.station.scene.loose_objects import LooseObjects
from uwsim.operator.station.scene.scene import Scene
from uwsim.operator.station.sessions.exercise import Judged
from uwsim.operator.station.sessions.inspection import Inspection
from uwsim.operator.station.start.prepared import load_navigation
from uwsim.operator.station.start.user_rosbridge import UserRosbridge
from uwsim.operator.station.views.arrivals import Arrivals
from uwsim.operator.station.views.snapshots import Snapshots
from uwsim.operator.station.views.views import Views
from uwsim.recording import Recorder

SHOWN = ("telemetry", "sensor_gauges", PLACED.name, "image_raw/compressed", "picture/compressed")
"""Name endings of the channels that the page shows: a modem, with its low capacity, carries only these by default."""


class Running:
    """A live simulator, from `start` to `stop`.

    The map is built from the start, so that late visitors see all of it. wake: called when a picture may be due. truth:
    whether the true position may be shown. folder: where notes are written. edition: a number that increases when a
    change of a parameter changes its description; see `notice_changes`. replay: the replay that the simulator
    follows, if any. In a replay, the truth is shown, and all values are those aboard, without a link. branched_from:
    the point in a replay at which a pilot took the helm, or "".
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
        self.pilot = Pilot(self.far, self.table.steering, near=live)
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
        self.judged: Judged | None = None
        self.plan: PlanFlight | None = None
        self.rosbridge: RosbridgeClient | None = None
        self.edition = 0
        self._described = sim.parameters.scenario
        self.snapshots = Snapshots(live, table, self.views, self.arrivals)
        self.inspection = Inspection(self.snapshots, lambda: self.recorder, folder or Path.cwd())

    @property
    def flown(self) -> Judged:
        """The exercise that is flown. Raises ValueError if there is none."""
        if self.judged is None:
            raise ValueError("no exercise is flown")
        return self.judged

    @property
    def replayed(self) -> Replay:
        """The replay that the simulator follows. Raises ValueError if there is none."""
        if self.replay is None:
            raise ValueError("no flight is replayed")
        return self.replay

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
        for link in (self.carrier, self.arrivals):
            if link is not None:
                link.start()
        for name, ping_map in self.maps.items():
            offered = [each for each in self.table.channels if each.read == ping_map.read_changes]
            for channel in offered:  # through the feed, which gives the whole map to a page that subscribes later
                self.feed.listen(channel, lambda reading: None)
            if not offered:
                rate_hz = self.table.pings[name].rate_hz
                self.live.every(1.0 / rate_hz, ping_map.read_changes, lambda message: None)
        for watching in (self.objects, self.life, self.judged, self.flight):
            if watching is not None:
                watching.start()

    def join(self, rosbridge: UserRosbridge) -> None:
        """Join the user's rosbridge with the topics of the paper's simulator, as `uwsim ros connect` does."""
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

    def end_plan(self, because: str) -> None:
        """End the plan being flown, if any."""
        if self.plan is not None:
            self.plan.stop(because)

    def commands(self) -> list[str]:
        """Return the commands that a pilot may issue by name, besides the services `drive` and `all_stop`.

        In an exercise, only those to a vehicle are included.
        """
        piloted = [each for _, each in sorted(COMMANDS.items()) if each.is_piloted]
        return [each.name for each in piloted if self.judged is None or each.crosses_link]

    def topics(self) -> list[GuestTopic]:
        """Return the topics of all views."""
        guests = [each for each in (self.views, self.arrivals, self.objects, self.life) if each is not None]
        return [topic for each in guests for topic in each.topics()]
