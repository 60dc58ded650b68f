"""MavlinkVehicle: one vehicle as a MAVLink system, like ArduSub's: telemetry out, commands, sticks and missions in."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from uwsim.base.extras import need_extra
from uwsim.bridges.actions import SUCCEEDED, Action, Goal
from uwsim.bridges.actions.action import Route
from uwsim.bridges.actions.table import SPEED_M_S
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.mavlink.earth import NED_FROM_ENU, Home
from uwsim.bridges.mavlink.endpoint import Endpoint, Peer, Wire
from uwsim.bridges.mavlink.missions import MissionStore, route_of
from uwsim.bridges.mavlink.modes import AUTO, GUIDED, HOLDS_OF, MANUAL, NAMES, mode_of
from uwsim.bridges.mavlink.parameters import ParameterServer
from uwsim.bridges.mavlink.telemetry import RATE_HZ, State, messages, read
from uwsim.bridges.rare_log import RareLog
from uwsim.channels import Channel, Service
from uwsim.channels.feed import Readings
from uwsim.live import LiveSimulator, NotRunningError

SYSTEM, COMPONENT = 1, 1
HOME = Home(33.810313, -118.393867)
"""The world's origin for a scenario without a georeference; assumed, in the sea off California."""
HEARTBEAT_S = 1.0
WAIT_S = 0.02
OUTPUT_MAX, PARSERS_MAX = 1000, 100
SUBMARINE, ARDUPILOT = 12, 3  # MAV_TYPE, MAV_AUTOPILOT
ARMED, MANUAL_INPUT, STABILIZED, CUSTOM_MODE = 128, 64, 16, 1  # MAV_MODE_FLAG
STANDBY, ACTIVE, CRITICAL = 3, 4, 5  # MAV_STATE
DONE, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = 0, 1, 2, 3, 4  # MAV_RESULT
CAPABILITIES = 1 << 1 | 1 << 2 | 1 << 7 | 1 << 8 | 1 << 13 | 1 << 17
"""MAV_PROTOCOL_CAPABILITY: float parameters, MISSION_ITEM_INT, local and global targets, MAVLink 2, C casts."""
WARNING, INFO = 4, 6  # MAV_SEVERITY
LOCAL_FRAMES, GLOBAL_FRAMES = (1,), (5, 6, 11)  # MAV_FRAME
POSITION_IGNORED, YAW_IGNORED = 0b111, 1 << 10
NEUTRAL_THROTTLE = 500


class MavlinkVehicle(Bridge):
    """A vehicle of a live simulator that ground stations see as an ArduSub (system 1, component 1).

    Messages and modes are those of docs/connections/ardupilot.md. A vehicle is disarmed until a ground station arms it,
    which also undocks it; sticks and targets have no effect before. Commands obey the station's pilot like those of
    other bridges, and are logged and recorded.

    action: the vehicle's action `fly_path`, which flies GUIDED targets and missions; None for a vehicle without. home:
    where the world's origin is. Raises OSError if the socket cannot be opened, and MissingExtraError without pymavlink.
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
        home: Home = HOME,
    ) -> None:
        need_extra("pymavlink", "mavlink", "--mavlink")
        from pymavlink.dialects.v20 import ardupilotmega

        super().__init__("mavlink", live, channels, services, feed)
        self._live = live
        self._dialect = ardupilotmega
        self._mav = ardupilotmega.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
        self._action, self._home = action, home
        self.vehicle = next(iter(live.vehicles)) if action is None else action.source.name
        self._wire = Wire(endpoint)
        self.endpoint = self._wire.endpoint
        self._rare = RareLog(logging.getLogger("uwsim.mavlink"))
        self._parsers: dict[Peer, Any] = {}
        self._output: deque[Any] = deque(maxlen=OUTPUT_MAX)  # from other threads
        self._state: State | None = None
        self._events = 0
        self._said = ""
        self._armed = False
        self._goal: Goal | None = None
        self._flies = MANUAL  # GUIDED or AUTO while a goal is flown
        self._target: Route | None = None
        self._parameters = ParameterServer(live, self._mav, self._send)
        self._mission = MissionStore(self._mav, self._send, self.say)
        self._stick = self._stick_channel()
        self._heartbeat_s = -math.inf
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="uwsim-mavlink", daemon=True)

    def _stick_channel(self) -> Channel | None:
        """Return the command channel of MANUAL_CONTROL, which ends after a time without sticks."""
        if self._action is None:
            return None
        steering, name = self._action.steering, self.vehicle
        idle = {"surge": 0.0, "sway": 0.0, "heave": 0.0, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}
        return Channel(
            "manual_control", "mavlink/MANUAL_CONTROL", "in", f"the sticks of '{name}'",
            apply=lambda live, efforts: steering.give(live, "set_effort", **efforts),
            abandoned=lambda live: steering.give(live, "set_effort", **idle), idle=idle, watch=steering.watch,
            rights=steering.rights,
        )  # fmt: skip

    def start(self) -> MavlinkVehicle:
        """Start; return self. Raises NotRunningError if the simulator does not run."""
        truth = self._action is None or self._action.uses_truth
        source = self._action.source if self._action is not None else None
        if source is not None:
            if not truth:
                _ = self._live.vehicles[self.vehicle].estimate  # starts the navigation
            self._going_on.append(
                self._live.every(1 / RATE_HZ, lambda sim: read(sim, source, truth=truth), self._take_state)
            )
        self._thread.start()
        return self

    def __enter__(self) -> MavlinkVehicle:
        return self.start()

    def close(self) -> bool:
        """Stop: the thread, the flight, the socket."""
        was_open = super().close()
        if was_open:
            self._end_flight()
            self._closing.set()
            if self._thread.is_alive():
                self._thread.join(2.0)
            self._wire.close()
        return was_open

    # Out

    def _take_state(self, state: State) -> None:
        """Receive a reading on the simulator's thread."""
        self._state = state
        self._output.append(state)

    def say(self, text: str, severity: int = WARNING) -> None:
        """Send a text, of which MAVLink carries 50 bytes, on any thread."""
        for start in range(0, min(len(text), 200), 50):
            self._output.append(self._mav.statustext_encode(severity, text[start : start + 50].encode()))

    def _send(self, message: Any, peer: Peer | None = None) -> None:
        self._wire.send(bytes(message.pack(self._mav)), peer)

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                for peer, data in self._wire.receive(WAIT_S):
                    for message in self._parsed(peer, data):
                        self._handle(peer, message)
                self._send_what_is_due()
            except NotRunningError:
                self._rare.warning("the simulator does not run")
            except Exception:
                self.log.exception("MAVLink: a message failed")

    def _parsed(self, peer: Peer, data: bytes) -> list[Any]:
        if peer not in self._parsers:
            self._parsers[peer] = self._dialect.MAVLink(None)
            self._parsers[peer].robust_parsing = True
            while len(self._parsers) > PARSERS_MAX:
                del self._parsers[next(iter(self._parsers))]
        return self._parsers[peer].parse_buffer(data) or []

    def _send_what_is_due(self) -> None:
        now_s = time.monotonic()
        if now_s - self._heartbeat_s >= HEARTBEAT_S:
            self._heartbeat_s = now_s
            self._send(self._heartbeat())
        while self._output:
            item = self._output.popleft()
            for message in messages(self._mav, item, self._home) if isinstance(item, State) else (item,):
                self._send(message)
            if isinstance(item, State):
                self._say_news(item)
        self._parameters.send_some()
        self._mission.ask_again(now_s)

    def _say_news(self, state: State) -> None:
        """Report events, failsafes and lost holds as texts, once each."""
        events = self._live.simulator.events
        for event in list(events)[self._events :]:
            self.say(f"{event.name} {' '.join(f'{k}={v}' for k, v in event.values.items())}")
        self._events = len(events)
        news = state.failsafe or state.hold_note
        if news and news != self._said:
            self.say(news)
        self._said = news

    @property
    def mode(self) -> int:
        """The present mode: that of the flight, or of the active holds."""
        if self._flies != MANUAL:
            return self._flies
        return mode_of(() if self._state is None else self._state.holds)

    def _heartbeat(self) -> Any:
        state, mode = self._state, self.mode
        base = CUSTOM_MODE | (ARMED if self._armed else 0) | (MANUAL_INPUT if self._flies == MANUAL else 0)
        base |= STABILIZED if mode != MANUAL else 0
        is_critical = state is not None and bool(state.failsafe)
        status = CRITICAL if is_critical else ACTIVE if self._armed else STANDBY
        return self._mav.heartbeat_encode(SUBMARINE, ARDUPILOT, base, mode, status, 3)

    # In

    def _handle(self, peer: Peer, message: Any) -> None:
        name = f"on_{message.get_type().lower()}"
        owners = (self, self._mission, self._parameters)
        handler = next((getattr(owner, name) for owner in owners if hasattr(owner, name)), None)
        if handler is None or getattr(message, "target_system", getattr(message, "target", SYSTEM)) not in (0, SYSTEM):
            return
        try:
            handler(peer, message)
        except (ValueError, RuntimeError) as error:
            self.say(str(error))
            self.refuse(str(error))

    def refuse(self, reason: str) -> None:
        """Log a rejected command, at most once a minute."""
        self._rare.warning(reason)

    def _require_armed(self, what: str) -> None:
        if not self._armed:
            raise ValueError(f"{what}: the vehicle is not armed")

    def _command(self, name: str, **arguments: Any) -> None:
        """Issue a command if the station's pilot permits it, and wait until it has taken effect."""
        if self._action is not None:
            self._action.steering.rights.require(name, {"data": arguments.get("on", True)})
        self._live.command(name, vehicle=self.vehicle, **arguments).result(timeout=5.0)

    def on_manual_control(self, peer: Peer, message: Any) -> None:
        """Set the efforts of a stick, in the body's axes forward, right, up and clockwise."""
        if not self._armed or self._flies != MANUAL or self._stick is None:
            return
        axes = {name: getattr(message, name) for name in "xyzr"}
        if any(not -1000 <= value <= 1000 for value in axes.values()):
            raise ValueError(f"MANUAL_CONTROL: {axes}: must be in [-1000, 1000]")
        heave = (axes["z"] - NEUTRAL_THROTTLE) / NEUTRAL_THROTTLE
        self.apply(self._stick, {"surge": axes["x"] / 1000, "sway": -axes["y"] / 1000,
                                 "heave": max(-1.0, min(heave, 1.0)), "yaw": -axes["r"] / 1000})  # fmt: skip

    def on_rc_channels_override(self, peer: Peer, message: Any) -> None:
        """Sticks as ArduSub's RC input: pitch, roll, throttle, yaw, forward, lateral on channels 1 to 6 [us]."""
        if not self._armed or self._flies != MANUAL or self._stick is None:
            return
        efforts = {}
        for k, (axis, sign) in enumerate(
            (("pitch", -1), ("roll", 1), ("heave", 1), ("yaw", -1), ("surge", 1), ("sway", -1)), start=1
        ):
            pulse_us = getattr(message, f"chan{k}_raw")
            efforts[axis] = 0.0 if pulse_us in (0, 0xFFFF) else sign * max(-1.0, min((pulse_us - 1500) / 400, 1.0))
        self.apply(self._stick, efforts)

    def on_set_mode(self, peer: Peer, message: Any) -> None:
        """Change the mode."""
        self._set_mode(message.custom_mode)

    def _set_mode(self, mode: int) -> None:
        if mode not in NAMES:
            raise ValueError(f"mode {mode}: must be one of {', '.join(f'{n} ({k})' for k, n in NAMES.items())}")
        if mode in (AUTO, GUIDED):
            self._require_armed(NAMES[mode])
            self._begin(mode, route_of(self._mission.items, self._home)[0] if mode == AUTO else None)
            return
        self._end_flight()
        self._command("hold", **dict.fromkeys(HOLDS_OF[mode], True))

    def _begin(self, mode: int, route: Route | None) -> None:
        """Fly a route, or, in GUIDED without a target, hold what the vehicle can hold."""
        if self._action is None:
            raise ValueError(f"{NAMES[mode]}: the vehicle has no estimate to fly by")
        self._end_flight()
        if route is None:
            holds = self._live.simulator.vehicles[self.vehicle].gate.holds
            possible = [] if holds is None else holds.possible
            self._command("hold", **{hold: True for hold in ("heading", "depth", "position") if hold in possible})
        else:
            given = replace(self._action, route=lambda goal: goal, feedback=lambda progress: progress,
                            result=lambda elapsed_s, why: why)  # fmt: skip
            numbers = route_of(self._mission.items, self._home)[1] if mode == AUTO else []
            goal = Goal(self._live, given, route, lambda progress: self._progress(numbers, progress.leg),
                        lambda status, why: self._ended(goal, numbers, status, why))  # fmt: skip
            goal.start()
            self._goal, self._target = goal, route
        self._flies = mode

    def _progress(self, numbers: list[int], leg: int) -> None:
        if numbers:
            self._output.append(self._mav.mission_current_encode(numbers[min(leg, len(numbers) - 1)]))

    def _ended(self, goal: Goal, numbers: list[int], status: int, why: str) -> None:
        if status == SUCCEEDED:
            for number in numbers:
                self._output.append(self._mav.mission_item_reached_encode(number))
            self.say("Mission complete" if numbers else "Target reached", INFO)
        elif goal is self._goal:
            self.say(f"{NAMES[self._flies]} ended: {why}")

    def _end_flight(self) -> None:
        goal, self._goal, self._target, self._flies = self._goal, None, None, MANUAL
        if goal is not None:
            goal.close()

    def on_set_position_target_local_ned(self, peer: Peer, message: Any) -> None:
        """Fly to a position, in GUIDED."""
        if message.coordinate_frame not in LOCAL_FRAMES:
            raise ValueError(f"target: frame {message.coordinate_frame}: must be local NED (1)")
        self._fly_to(message, NED_FROM_ENU.T @ (message.x, message.y, message.z))

    def on_set_position_target_global_int(self, peer: Peer, message: Any) -> None:
        """Fly to a place, in GUIDED."""
        if message.coordinate_frame not in GLOBAL_FRAMES:
            raise ValueError(f"target: frame {message.coordinate_frame}: must be a global one (5, 6, 11)")
        self._fly_to(message, self._home.world_m(1e-7 * message.lat_int, 1e-7 * message.lon_int, message.alt))

    def _fly_to(self, message: Any, point: Any) -> None:
        self._require_armed("target")
        if self._flies != GUIDED:
            raise ValueError("target: must be in mode GUIDED")
        if message.type_mask & POSITION_IGNORED:
            raise ValueError("target: only positions are supported, not velocities or accelerations")
        if not (all(math.isfinite(part) and abs(part) < 1e5 for part in point) and point[2] <= 0):
            raise ValueError(f"target = {[round(float(part), 2) for part in point]} m: must be near and under water")
        yaw = None if message.type_mask & YAW_IGNORED else math.pi / 2 - message.yaw
        route = Route(point.reshape(1, 3), SPEED_M_S, yaw)
        known = self._target
        if known is None or abs(known.points_world_m - route.points_world_m).max() > 1e-3 or known.heading_rad != yaw:
            self._begin(GUIDED, route)

    def on_command_long(self, peer: Peer, message: Any) -> None:
        """Obey a command, and acknowledge it."""
        try:
            result = self._obey(peer, message)
        except (ValueError, RuntimeError) as error:
            self.say(str(error))
            result = FAILED
        self._send(self._mav.command_ack_encode(message.command, result), peer)

    def _obey(self, peer: Peer, message: Any) -> int:
        d, first, second = self._dialect, message.param1, message.param2
        if message.command == d.MAV_CMD_COMPONENT_ARM_DISARM:
            self._arm() if first == 1 else self._disarm()
        elif message.command == d.MAV_CMD_DO_SET_MODE:
            self._set_mode(int(second))
        elif message.command == d.MAV_CMD_DO_FLIGHTTERMINATION:
            self._end_flight()
            self._armed = False
            self._command("all_stop", on=first >= 0.5)
        elif message.command == d.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
            self._output.append(self._version())  # after the acknowledgement
        elif message.command == d.MAV_CMD_REQUEST_MESSAGE:
            answers = {d.MAVLINK_MSG_ID_AUTOPILOT_VERSION: self._version, d.MAVLINK_MSG_ID_HOME_POSITION: self._place,
                       d.MAVLINK_MSG_ID_HEARTBEAT: self._heartbeat}  # fmt: skip
            if int(first) not in answers:
                return UNSUPPORTED
            self._output.append(answers[int(first)]())
        elif message.command == d.MAV_CMD_GET_HOME_POSITION:
            self._output.append(self._place())
        elif message.command == d.MAV_CMD_MISSION_START:
            self._set_mode(AUTO)
        else:
            return UNSUPPORTED
        return DONE

    def _arm(self) -> None:
        vehicle = self._live.simulator.vehicles[self.vehicle]
        vehicle.gate.require_no_stop("arm")
        if not vehicle.released:
            self._command("undock")
        self._armed = True

    def _disarm(self) -> None:
        self._end_flight()
        self._armed = False
        self._command("hold")
        self._command("set_effort")

    def _version(self) -> Any:
        return self._mav.autopilot_version_encode(
            CAPABILITIES, 4 << 24 | 5 << 16 | 255, 0, 0, 0, bytes(8), bytes(8), bytes(8), 0, 0, 0
        )

    def _place(self) -> Any:
        lat, lon = round(1e7 * self._home.lat_deg), round(1e7 * self._home.lon_deg)
        return self._mav.home_position_encode(lat, lon, 0, 0.0, 0.0, 0.0, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0)
