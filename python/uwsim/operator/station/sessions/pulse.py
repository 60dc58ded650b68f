"""The station's heartbeat, which zeroes efforts that no pilot renews, starts pictures and publishes the state."""

from __future__ import annotations

import logging
import math
import threading
import time

from uwsim.channels.guest import Values
from uwsim.channels.ros.build import message
from uwsim.channels.ros.own_types import STATION_STATE
from uwsim.live import NotRunningError
from uwsim.operator.station.controls.lease import Lease
from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.sessions.sessions import STATE, Sessions
from uwsim.simulator.failures.events import comment_of, notes_of

STATE_S = 0.5  # even if nothing has changed: a page that receives nothing for 1.5 s suspects its network
SILENT_S = 1.5  # silence of the pilot, who is pinged every second, after which it is reported
LOGGER = logging.getLogger("uwsim.operator.station")


class Pulse:
    """A thread that runs when something is due or `wake` is called, and twice a second while idle."""

    def __init__(self, lease: Lease) -> None:
        self._lease = lease
        self._woken = threading.Event()
        self._is_changed = self._is_closing = False
        self._sent_s = -math.inf
        self._thread = threading.Thread(target=self._run, name="uwsim-station", daemon=True)

    def start(self, sessions: Sessions) -> None:
        """Start beating."""
        self._sessions = sessions
        self._thread.start()

    def close(self) -> None:
        """Stop beating."""
        self._is_closing = True
        self._woken.set()
        if self._thread.ident is not None:
            self._thread.join()

    def wake(self) -> None:
        """Run now, because something may be due. May be called on any thread."""
        self._woken.set()

    def publish(self) -> None:
        """Publish the state now, because it has changed. May be called on any thread."""
        self._is_changed = True
        self._woken.set()

    def _run(self) -> None:
        rest_s = 0.0
        while not self._is_closing:
            self._woken.wait(rest_s)
            self._woken.clear()
            running = self._sessions.running
            try:
                rest_s = self._beat(running, time.monotonic())
            except NotRunningError:
                LOGGER.debug("the simulator has stopped")
            except Exception:
                LOGGER.exception("the station's beat failed")
                rest_s = STATE_S

    def _beat(self, running: Running | None, now_s: float) -> float:
        """Perform the actions that are due. Return the time [s] until the next one."""
        if self._is_changed or now_s >= self._sent_s + STATE_S:
            self._is_changed, self._sent_s = False, now_s
            self._publish_state(running)
        rests_s = [self._sent_s + STATE_S - now_s]
        if running is not None:
            rests_s += [running.pilot.beat(), running.views.beat(now_s)]
        return max(min(rests_s), 0.0)

    def _publish_state(self, running: Running | None) -> None:
        if running is not None:
            running.notice_changes()
        time_ns = 0 if running is None else running.live.time_ns
        self._sessions.node.publish(STATE, message(STATION_STATE, **self._state(running)), time_ns)

    def _state(self, running: Running | None) -> Values:
        sessions, lease = self._sessions, self._lease
        state = {
            "phase": sessions.phase if running is not None or sessions.phase != "running" else "starting",
            "session": sessions.number,
            "edition": 0 if running is None else running.edition,
            "pilot": lease.pilot,
            "pilot_silence": self._pilot_silence_s(),
            "member_ids": list(lease.members),
            "member_names": list(lease.members.values()),
            "asking": list(lease.asking),
            "driver": "" if running is None else running.driver,
            "lost_by": lease.lost_by,
            "recording": "" if running is None else running.recording,
            "flight": "" if running is None or running.flight is None else running.flight.name,
            "flight_trouble": "" if running is None or running.flight is None else running.flight.trouble,
        }
        return state if running is None else state | _progress(running)

    def _pilot_silence_s(self) -> float:
        pilot = self._lease.pilot
        silence_s = self._sessions.node.silence_s(pilot) if pilot else 0.0
        return silence_s if silence_s >= SILENT_S else 0.0


def _progress(running: Running) -> Values:
    """Return a simulator's progress as fields of the state."""
    live, rosbridge = running.live, running.rosbridge
    return {
        "scenario": live.simulator.scenario.name,
        "error": str(live.error or ""),
        "comment": comment_of(live.simulator.events),
        "notes": len(notes_of(live.simulator.events)),
        "time": 1e-9 * live.time_ns,
        "paused": live.paused,
        "speed": 0.0 if live.speed == "max" else live.speed,
        "factor": live.factor,
        "lateness": live.lateness,
        "rosbridge": "" if rosbridge is None else rosbridge.url,
        "rosbridge_trouble": "" if rosbridge is None else rosbridge.client.trouble,
        "rosbridge_refusals": "" if rosbridge is None else rosbridge.refusals,
    }
