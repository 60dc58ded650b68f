"""The pilot's screen: fan, tapes, panel and messages. It passes keys to the hands."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
import time
from collections.abc import Iterable
from typing import Any, ClassVar

from rich.text import Text
from textual import events
from textual.app import App, ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import RichLog, Static

from uwsim.operator.teleop import panel
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.fan import draw_fan
from uwsim.operator.teleop.gamepad import Gamepads
from uwsim.operator.teleop.keys import ALL_STOP, END_STOP, HELP, HELP_TEXT, LESS, MARK, MORE, SERVICES, SWITCHES
from uwsim.operator.teleop.tapes import depth_tape, heading_tape
from uwsim.operator.teleop.terminal import KeyReleased, ReleaseDriver

FRAME_S = 0.1
PAD_S, LOOK_S = 0.02, 1.0
SILENT_S = 1.0  # time without telemetry after which the pilot is warned
LATE = 2.5  # the same over a slow modem, in multiples of the last interval
QUIT_S = 3.0  # time limit for restoring the terminal
INTERRUPTED = 130  # exit code, as for all commands


class TeleopApp(App[None]):
    """Draws a connection's readout, and passes keys and gamepad input to its hands. name: the vehicle's name."""

    CSS = """
    Screen { layout: vertical; background: $background; }
    #top { height: 1; background: $primary-darken-2; }
    #middle { height: 1fr; }
    #left { width: 1fr; }
    #heading { height: 2; }
    #fan { height: 1fr; }
    #depth { width: 14; height: 1fr; padding: 0 1; }
    #right { width: 43; padding: 0 1; }
    #efforts { height: 7; margin-top: 1; }
    #figures { height: 9; }
    #warnings { height: 2; }
    #log { height: 1fr; min-height: 3; background: $background; scrollbar-size: 0 0; }
    #keys { height: 1; color: $text-muted; }
    """
    BINDINGS: ClassVar[Any] = [("ctrl+q", "quit", "quit"), ("ctrl+c", "quit", "quit")]
    ENABLE_COMMAND_PALETTE = False

    def __init__(self, connection: Connection, name: str, gamepads: Gamepads | None = None) -> None:
        super().__init__(driver_class=ReleaseDriver if sys.platform != "win32" else None)
        self.connection = connection
        self.hands = connection.hands
        self.flown = name
        self.gamepads = gamepads
        self.marks: list[str] = []
        self._last_text = ""
        self._was_stopped = False
        connection.report = self.report

    def compose(self) -> ComposeResult:
        """Return the widgets."""
        yield Static(id="top")
        with Horizontal(id="middle"):
            with Vertical(id="left"):
                yield Static(id="heading")
                yield Static(id="fan")
            yield Static(id="depth")
            with Vertical(id="right"):
                yield Static(id="figures")
                yield Static(id="efforts")
                yield Static(id="warnings")
                yield RichLog(id="log", wrap=True, min_width=20, max_lines=200)
        yield Static("w s a d q e b space: drive   x X: all stop, its end   - =: effort   ?: keys", id="keys")

    def on_mount(self) -> None:
        """Start listening and drawing; shut down cleanly on signals."""
        self.query_one("#log", RichLog).can_focus = False
        loop = asyncio.get_running_loop()
        for name in ("SIGTERM", "SIGHUP", "SIGINT"):
            if hasattr(signal, name) and not self.is_headless:
                loop.add_signal_handler(getattr(signal, name), self.end_at_once)
        self.connection.start()
        self.set_interval(FRAME_S, self.draw)
        if self.gamepads is not None:
            self.gamepads.look()
            self.set_interval(LOOK_S, self.gamepads.look)
            self.set_interval(PAD_S, self._poll_gamepads)

    def end_at_once(self) -> None:
        """Set the efforts to zero and quit, even if the terminal accepts no more output."""
        self.connection.stop()
        last = threading.Timer(QUIT_S, os._exit, (INTERRUPTED,))
        last.daemon = True
        last.start()
        self.exit(return_code=INTERRUPTED)

    def report(self, text: str) -> None:
        """Show the pilot a line of text; may be called on any thread."""
        if text == self._last_text:
            return
        self._last_text = text
        line = Text(f"{time.strftime('%H:%M:%S')} {text}")
        try:
            self.call_later(self._write, line)
        except RuntimeError:  # the screen is gone
            return

    def _write(self, line: Text) -> None:
        if self.is_running:  # as for `draw`
            self.query_one("#log", RichLog).write(line)

    # Input

    def on_key(self, event: events.Key) -> None:
        """Handle a key."""
        character = event.character or ""
        if character:
            self.press(character)

    def on_key_released(self, message: KeyReleased) -> None:
        """Record that this key was released, and thus that the terminal reports releases."""
        self.hands.reports_releases = True
        self.hands.release(message.character)

    def on_app_blur(self) -> None:
        """Release all keys when the terminal loses focus, since releases would no longer be reported."""
        self.hands.drop()

    def press(self, character: str) -> None:
        """Perform the action assigned to a character."""
        if character in SWITCHES:
            self.connection.do(SWITCHES[character])
        elif character in SERVICES:
            self.connection.call(SERVICES[character])
        elif character in (ALL_STOP, END_STOP):
            self.hands.press(ALL_STOP)
            self.connection.all_stop(on=character == ALL_STOP)
        elif character in (LESS, MORE):
            self.hands.change_share(-1 if character == LESS else 1)
        elif character == MARK:
            self._mark()
        elif character == HELP:
            self._last_text = ""
            self.report(HELP_TEXT)
        else:
            self.hands.press(character)

    def _mark(self) -> None:
        """Store the current position. This is a function of the published keyboard, not a command."""
        readout = self.connection.readout
        east, north, up = readout.position_m
        self.marks.append(
            f"{readout.mission_s:.1f} s: {east:.2f}, {north:.2f}, {up:.2f} m, {readout.depth_m:.2f} m deep"
        )
        self._last_text = ""
        self.report(f"mark {len(self.marks)}: {self.marks[-1]}")

    def _poll_gamepads(self) -> None:
        if self.gamepads is None:
            return
        efforts, pressed, released = self.gamepads.poll()
        self.hands.set_sticks(efforts)
        for character in pressed:
            self.press(character)
        for character in released:
            self.hands.release(character)

    # Display

    def draw(self) -> None:
        """Redraw everything."""
        if not self.is_running:  # timers and queued calls still arrive while the screen is being taken down
            return
        self.hands.beat()
        readout = self.connection.readout
        if readout.all_stop and not self._was_stopped:
            self.hands.drop()  # so that a held key does not move the vehicle when all stop is released
        self._was_stopped = readout.all_stop
        heading, fan, depth = (self.query_one(name, Static) for name in ("#heading", "#fan", "#depth"))
        heading.update(heading_tape(readout.heading_deg, heading.size.width))
        fan.update(draw_fan(readout.angles_rad, readout.ranges_m, fan.size.width, fan.size.height))
        depth.update(depth_tape(readout.depth_m, readout.seabed_m, depth.size.height))
        self.query_one("#figures", Static).update(panel.figures(readout))
        self.query_one("#efforts", Static).update(panel.effort_bars(self.hands.efforts(), readout.efforts))
        self.query_one("#warnings", Static).update(Text("  ".join(self._warnings()), "bold white on red"))
        self.query_one("#top", Static).update(self._top_line())

    def _warnings(self) -> Iterable[str]:
        if self.connection.state != "connected":
            yield f"{self.connection.state.upper()}: {self.connection.url}"
        elif self.connection.silence_s > max(SILENT_S, LATE * self.connection.interval_s):
            yield f"NO TELEMETRY FOR {min(self.connection.silence_s, 999.0):.0f} s"
        if self.connection.readout.link_fault:
            yield self.connection.readout.link_fault
        yield from self.connection.readout.warnings
        if self.connection.readout.released is False:
            yield "DOCKED"

    def _top_line(self) -> Text:
        keys = "key releases" if self.hands.reports_releases else "keys end by themselves"
        pad = f"gamepad {self.gamepads.name}" if self.gamepads is not None and self.gamepads.name else keys
        helm = "at the helm" if self.hands.has_helm else "helm free"
        left = f" uwsim teleop   {self.flown}   {self.connection.state}"
        right = f"{helm}   {round(100 * self.hands.share)} % effort   {pad} "
        return Text(left + right.rjust(max(self.size.width - len(left), 0)), "bold")
