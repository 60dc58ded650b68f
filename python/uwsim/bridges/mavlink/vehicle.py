"""MavlinkVehicle: a vehicle as a MAVLink system that sends telemetry and accepts commands, sticks and missions."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.base.axes import AXES
from uwsim.base.extras import need_extra
from uwsim.bridges.actions import Action
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.mavlink.backlog import Backlog
from uwsim.bridges.mavlink.cameras import camera_components
from uwsim.bridges.mavlink.component import (
    CRITICAL_TEXT,
    DONE,
    FAILED,
    NOTICE_TEXT,
    SET_MODE,
    SYSTEM,
    WARNING_TEXT,
    Commands,
    Component,
    Given,
)
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.earth import HOME, ned_from_frd
from uwsim.bridges.mavlink.endpoint import Wire
from uwsim.bridges.mavlink.fence import FenceKeeper
from uwsim.bridges.mavlink.flight import Flight
from uwsim.bridges.mavlink.gimbal import DEVICE, Gimbal
from uwsim.bridges.mavlink.missions import MissionStore
from uwsim.bridges.mavlink.modes import CUSTOM_MODE, MANUAL, POSHOLD
from uwsim.bridges.mavlink.parameters import ParameterServer
from uwsim.bridges.mavlink.refusals import TARGETS, Refusals
from uwsim.bridges.mavlink.servos import Servos
from uwsim.bridges.mavlink.settings import Settings
from uwsim.bridges.mavlink.state import State, read
from uwsim.bridges.mavlink.stations import Stations, sender_of
from uwsim.bridges.mavlink.sticks import Sticks
from uwsim.bridges.mavlink.streams import Streams
from uwsim.bridges.mavlink.targets import Targets
from uwsim.bridges.mavlink.telemetry import KINDS, origin, place
from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.video.video import VideoStream
from uwsim.channels import Channel, Service
from uwsim.channels.channel import ended_by
from uwsim.channels.delivery.feed import Readings
from uwsim.live import LiveSimulator, NotRunningError, Subscription
from uwsim.mapping.files.georeference import Place
from uwsim.missions import OwnVehicle
from uwsim.missions.items import checked
from uwsim.missions.pictures import PictureFolder

AUTOPILOT = 1
HEARTBEAT_S = 1.0
WAIT_S = 0.02
SLICE_S = 0.02  # time for messages that are not urgent, after which the network is looked at again
DEPTH_MAX = 4
SUBMARINE, ARDUPILOT = 12, 3  # MAV_TYPE, MAV_AUTOPILOT
ARMED, MANUAL_INPUT, STABILIZED = 128, 64, 16  # MAV_MODE_FLAG
STANDBY, ACTIVE, CRITICAL = 3, 4, 5  # MAV_STATE
CAPABILITIES = 1 << 1 | 1 << 2 | 1 << 3 | 1 << 7 | 1 << 8 | 1 << 13 | 1 << 14 | 1 << 15 | 1 << 17
"""MAV_PROTOCOL_CAPABILITY: float parameters, integer missions and commands, targets (2), MAVLink 2, fences, rally
points, C casts."""
VERSION = 4 << 24 | 5 << 16 | 255
"""The version reported to ground stations: ArduSub 4.5.0."""
TEXT_BYTES, TEXT_MAX = 50, 200


class MavlinkVehicle(Bridge):
    """A vehicle of a live simulator that ground stations see as an ArduSub (system 1, component 1) with its cameras.

    For messages and modes, see docs/connections/ardupilot.md. A vehicle is disarmed until a ground station arms it,
    which also undocks it; until then, sticks and targets have no effect. As on other bridges, commands are refused
    while the station's pilot has the controls, and are logged and recorded.

    action: the vehicle's action `fly_path`, which flies GUIDED targets and missions, or None if it has none. home: the
    world's location on Earth, if it has one. pictures: the folder of those that missions take, if any. video: the
    stream of one of its cameras, to be announced to ground stations. Raises OSError if the socket cannot be opened, and
    MissingExtraError without pymavlink.
    """

    peer = "a MAVLink ground station"

    def __init__(
        self,
        live: LiveSimulator,
        endpoint: Endpoint,
        channels: Iterable[Channel],
        services: Iterable[Service] = (),
        *,
        action: Action | None,
        feed: Readings | None = None,
        home: Place | None = None,
        pictures: Path | None = None,
        video: VideoStream | None = None,
    ) -> None:
        need_extra("pymavlink", "--mavlink")
        from pymavlink.dialects.v20 import ardupilotmega

        super().__init__("mavlink", live, channels, services, feed)
        self._live, self._action, self._dialect = live, action, ardupilotmega
        self.vehicle = next(iter(live.vehicles)) if action is None else action.source.name
        self._craft = craft = Craft(live, self.vehicle, action, home or HOME, self.send_text)
        if pictures is not None and craft.vehicle.cameras:
            craft.pictures = self._picture_taker(PictureFolder(pictures, craft.home))
        self._wire = Wire(endpoint, self._parser)
        self.endpoint = self._wire.endpoint
        self._rare = RareLog(logging.getLogger("uwsim.mavlink"))
        self._events, self._texts, self._last_text = 0, 0, ""
        self._refusals = Refusals(lambda: 0.0 if craft.state is None else craft.state.time_s)
        self._heartbeat_s, self._shown = -math.inf, (MANUAL, False)
        self._readings: Subscription | None = None
        self._autopilot = autopilot = self._component(AUTOPILOT)
        settings = Settings()
        self._stations = stations = Stations(settings, self.send_text)
        self._gimbal = Gimbal(craft, autopilot)
        servos = Servos(craft, self._gimbal)
        self._fence = fence = FenceKeeper(craft, settings)
        self._mission = mission = MissionStore(
            autopilot.mav,
            autopilot.send,
            self.send_text,
            craft.output,
            lambda item: checked(item, craft, servos),
            fence,
        )
        self._flight = flight = Flight(craft, mission, servos, stations)
        self._streams = Streams(
            craft, autopilot, [*KINDS, *self._gimbal.kinds, *mission.kinds, *fence.kinds], self._read_at
        )
        sticks = Sticks(craft, flight, self._gimbal, stations, settings, self._efforts())
        targets = Targets(craft, flight, self._velocities())
        self._parameters = ParameterServer(craft, autopilot.mav, autopilot.send, settings)
        obeys = {520: self._on_capabilities, 410: self._on_home, **flight.commands, **targets.commands,
                 **fence.commands, **self._streams.commands, **self._gimbal.commands, **servos.commands}  # fmt: skip
        answers = [self._answer, self._gimbal.answer, self._streams.answer]
        self._commands = Commands(autopilot, obeys, answers, self.send_text)
        self._owners = [self._commands, flight, targets, sticks, mission, self._parameters, self._streams,
                        self._gimbal, self]  # fmt: skip
        self._backlog = Backlog(lambda message: self._flight.stop_at_once(), self._dropped)
        self._depth = 0  # of commands that wait, each within the one before
        craft.meanwhile = self._handle_urgent
        self._cameras = camera_components(craft, self._component, self._gimbal.camera, DEVICE, video)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="uwsim-mavlink", daemon=True)

    def _component(self, number: int) -> Component:
        return Component(self._dialect, self._wire, number)

    def _picture_taker(self, folder: PictureFolder) -> Callable[[OwnVehicle, int], None]:
        """Return a function that takes a picture into a folder, and reports it as CAMERA_IMAGE_CAPTURED."""

        def take(vehicle: OwnVehicle, item: int) -> None:
            index, values = folder.take(vehicle, item)
            xyzw = Rotation.from_matrix(vehicle.pose.world_from_body[:3, :3]).as_quat()
            lat, lon = (round(1e7 * values[f"{name}_deg"]) for name in ("latitude", "longitude"))
            up_mm, boot_ms = round(-1e3 * values["depth_m"]), round(1e3 * values["time_s"]) % 2**32
            self._craft.output.put(
                self._autopilot.mav.camera_image_captured_encode(
                    boot_ms,
                    0,
                    1,
                    lat,
                    lon,
                    up_mm,
                    up_mm,
                    ned_from_frd(xyzw),
                    index,
                    1,
                    values["file"].encode(),
                )
            )

        return take

    def _efforts(self) -> Any:
        """Return a function that applies stick efforts through a channel that ends them; None without an action."""
        if self._action is None:
            return None
        steering, idle = self._action.steering, dict.fromkeys(AXES, 0.0)
        return self._door(
            "manual_control", "mavlink/MANUAL_CONTROL", f"the sticks of '{self.vehicle}'", idle,
            lambda live, efforts: steering.give(live, "set_effort", **efforts),
        )  # fmt: skip

    def _velocities(self) -> Any:
        """Return a function that applies a velocity (6,) likewise, under the name of the topic that does so."""
        if self._action is None:
            return None
        return self._door(
            self._action.source.topic("cmd_vel"), "mavlink/SET_POSITION_TARGET_LOCAL_NED",
            f"velocities of '{self.vehicle}'", np.zeros(6), self._action.steering.hold_velocity,
        )  # fmt: skip

    def _door(self, name: str, kind: str, description: str, idle: Any, apply: Any) -> Callable[[Any], None]:
        assert self._action is not None
        channel = Channel(
            name, kind, "in", description, apply=apply, authority=ended_by(idle, apply, self._action.steering)
        )
        return lambda given: self.apply(channel, given)

    def start(self) -> MavlinkVehicle:
        """Start; return self. Raises NotRunningError if the simulator is not running."""
        self._read_at(self._streams.reading_rate_hz)
        self._thread.start()
        return self

    def __enter__(self) -> MavlinkVehicle:
        return self.start()

    def close(self) -> bool:
        """End the flight, stop the thread and close the socket."""
        was_open = super().close()
        if was_open:
            if self._readings is not None:
                self._readings.cancel()
            if (goal := self._flight.end()) is not None:
                goal.close()
            self._closing.set()
            if self._thread.is_alive():
                self._thread.join(2.0)
            self._wire.close()
        return was_open

    # Out

    def _read_at(self, rate_hz: float) -> None:
        if self._readings is not None:
            self._readings.cancel()
        action = self._action
        if action is not None:
            truth = action.uses_truth
            if not truth:
                self._live.vehicles[self.vehicle].start_navigation("observer")
            self._readings = self._live.every(
                1 / rate_hz, lambda sim: read(sim, action.source, truth=truth), self._store_state
            )

    def _store_state(self, state: State) -> None:
        """Receive a reading on the simulator's thread."""
        self._craft.state = state
        self._craft.output.put(state)

    def send_text(self, text: str, severity: int = WARNING_TEXT, /) -> None:
        """Send a text, from any thread, in messages of up to 50 bytes.

        Of several, the last ends with a zero byte, by which stations know it (MAVLink, STATUSTEXT.chunk_seq). Pilots
        read values without a sign of equality.
        """
        plain = text.replace(" = ", " ").encode("ascii", "replace")
        data = plain if len(plain) <= TEXT_MAX else plain[: TEXT_MAX - 3] + b"..."
        self._texts = self._texts % 0xFFFF + 1
        number = self._texts if len(data) > TEXT_BYTES else 0
        for k, start in enumerate(range(0, len(data) + bool(number), TEXT_BYTES)):
            part = data[start : start + TEXT_BYTES]
            self._craft.output.put(self._autopilot.mav.statustext_encode(severity, part, number, k))

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                self._attend(0.0 if self._backlog else WAIT_S)
                until_s = time.monotonic() + SLICE_S
                while time.monotonic() < until_s and (each := self._backlog.take()) is not None:
                    self._handle(*each)
                self._attempt(self._flight.watch)
                self._attempt(self._watch_fence)
            except NotRunningError:
                self._rare.warning("the simulator does not run")
            except Exception:
                self.log.exception("MAVLink: a message failed")

    def _attend(self, wait_s: float) -> None:
        """Handle the stops that have arrived, then sticks, for a short time; send what is due; queue all others."""
        self._receive(wait_s)
        until_s = time.monotonic() + SLICE_S
        while time.monotonic() < until_s and (each := self._backlog.take(only_urgent=True)) is not None:
            self._handle(*each)
            self._receive(0.0)
        self._send_what_is_due()

    def _receive(self, wait_s: float) -> None:
        received = self._wire.receive(wait_s)
        for _, message in received:
            self._stations.hear(sender_of(message))
        self._backlog.sort(each for each in received if self._concerns(each[1]))

    def _handle_urgent(self) -> None:
        """Handle what is more urgent than a command that waits for its effect."""
        if self._depth == DEPTH_MAX:
            self._receive(0.0)  # which sets all stop
            self._send_what_is_due()
            return
        self._depth += 1
        try:
            self._attend(0.0)
        finally:
            self._depth -= 1

    def _concerns(self, message: Any) -> bool:
        """Return whether any part of the system handles a message."""
        name = f"on_{message.get_type().lower()}"
        return getattr(message, "target_system", getattr(message, "target", SYSTEM)) in (0, SYSTEM) and any(
            hasattr(owner, name) for owner in self._owners
        )

    def _dropped(self, peer: Address, message: Any) -> None:
        """Report a message that is not handled."""
        kind = message.get_type()
        self._rare.warning(f"{kind}: not handled: stopped meanwhile, or too many messages of one station wait")
        if kind in ("COMMAND_LONG", "COMMAND_INT", "SET_MODE"):
            number = SET_MODE if kind == "SET_MODE" else message.command
            ack = self._autopilot.mav.command_ack_encode(number, FAILED, 0, 0, *sender_of(message))
            self._autopilot.send(ack, peer)

    def _watch_fence(self) -> None:
        if self._fence.watch(is_armed=self._flight.is_armed):
            self._flight.set_mode(POSHOLD)

    def _parser(self) -> Any:
        parser = self._dialect.MAVLink(None)
        parser.robust_parsing = True
        return parser

    def _send_what_is_due(self) -> None:
        now_s = time.monotonic()
        shown = self._flight.mode, self._flight.is_armed
        if now_s - self._heartbeat_s >= HEARTBEAT_S or shown != self._shown:  # at once, as ArduPilot
            self._heartbeat_s, self._shown = now_s, shown
            self._autopilot.send(self._heartbeat())
            for camera in self._cameras:
                camera.component.send(camera.heartbeat())
        while (item := self._craft.output.take()) is not None:
            if not isinstance(item, State):
                self._autopilot.send(item() if callable(item) else item)
                continue
            self._streams.send(item)
            self._gimbal.follow(item)
            self._report_news(item)
        self._parameters.send_some()
        self._mission.retry(now_s)

    def _report_news(self, state: State) -> None:
        """Report events, failsafes and lost holds as texts, once each."""
        events = self._live.simulator.events
        for event in list(events)[self._events :]:
            if event.name != "hold_ends":  # `hold_note` has its reason
                self.send_text(event.text, NOTICE_TEXT)
        self._events = len(events)
        news = state.failsafe or state.hold_note
        if news and news != self._last_text:
            self.send_text(news, CRITICAL_TEXT if state.failsafe else WARNING_TEXT)
        self._last_text = news

    def _heartbeat(self) -> Any:
        state, mode, is_armed = self._craft.state, self._flight.mode, self._flight.is_armed
        by_hand = not is_armed or self._flight.is_by_sticks
        base = CUSTOM_MODE | (ARMED if is_armed else 0) | (MANUAL_INPUT if by_hand else 0)
        base |= STABILIZED if mode != MANUAL else 0
        is_critical = state is not None and bool(state.failsafe)
        status = CRITICAL if is_critical else ACTIVE if is_armed else STANDBY
        return self._autopilot.mav.heartbeat_encode(SUBMARINE, ARDUPILOT, base, mode, status, 3)

    # In

    def _handle(self, peer: Address, message: Any) -> None:
        if message.get_type() in TARGETS:
            self._attempt(lambda: self._pass_target(peer, message), self._refusals.is_new)
        else:
            self._attempt(lambda: self._pass(peer, message))

    def _pass_target(self, peer: Address, message: Any) -> None:
        self._pass(peer, message)
        self._refusals.accepted()

    def _pass(self, peer: Address, message: Any) -> None:
        """Pass a message to the part of the system that handles its type."""
        name = f"on_{message.get_type().lower()}"
        component = getattr(message, "target_component", AUTOPILOT)
        for camera in self._cameras:
            if hasattr(camera.commands, name) and (
                component == camera.component.number or (component == 0 and camera.commands.knows(message))
            ):
                getattr(camera.commands, name)(peer, message)
                if component:
                    return
        if component == 0 and not self._commands.knows(message) and self._is_for_cameras(message):
            return
        owner = next((owner for owner in self._owners if hasattr(owner, name)), None)
        if owner is not None and component in (0, AUTOPILOT):
            getattr(owner, name)(peer, message)

    def _attempt(self, act: Callable[[], object], is_new: Callable[[str], bool] = lambda text: True) -> None:
        """Do something; report why it fails, to the stations if it is new."""
        try:
            act()
        except (ValueError, RuntimeError) as error:
            if is_new(str(error)):
                self.send_text(str(error))
            self.refuse(str(error))

    def _is_for_cameras(self, message: Any) -> bool:
        return any(camera.commands.knows(message) for camera in self._cameras)

    def refuse(self, reason: str) -> None:
        """Log a rejected command, at most once a minute."""
        self._rare.warning(reason)

    def on_timesync(self, peer: Address, message: Any) -> None:
        """Answer a ground station that is measuring the delay."""
        if message.tc1 == 0:
            self._autopilot.send(self._autopilot.mav.timesync_encode(time.monotonic_ns(), message.ts1), peer)

    def on_set_gps_global_origin(self, peer: Address, message: Any) -> None:
        """Refuse to change the origin, which the scenario determines, and report the current one."""
        self._autopilot.send(origin(self._autopilot.mav, self._craft.home), peer)
        raise ValueError("SET_GPS_GLOBAL_ORIGIN: the scenario determines the origin")

    def _answer(self, number: int, value: float) -> Iterable[Any] | None:
        """Return the messages with an ID; see Answers."""
        makers: Mapping[int, Any] = {0: self._heartbeat, 148: self._version}
        return [makers[number]()] if number in makers else None

    def _on_capabilities(self, given: Given) -> int:
        given.integer(1, 1, 1)
        given.replies.append(self._version())
        return DONE

    def _on_home(self, given: Given) -> int:
        given.replies.append(place(self._autopilot.mav, self._craft))
        return DONE

    def _version(self) -> Any:
        return self._autopilot.mav.autopilot_version_encode(
            CAPABILITIES, VERSION, 0, 0, 0, bytes(8), bytes(8), bytes(8), 0, 0, 0
        )
