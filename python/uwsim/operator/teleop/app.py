"""The pilot's screen: all stop, numbers, a line of sonar, messages. It passes keys to the hands."""

from __future__ import annotations

import logging
import math
import os
import shutil
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from textwrap import wrap

from uwsim.base.axes import AXES
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.hands import ALL_STOP, END_STOP, HELP, HELP_TEXT, MARK, SERVICES, STEPS, SWITCHES, Hands
from uwsim.operator.teleop.terminal import BLUR, Terminal

FRAME_S = 0.1
SILENT_S = 1.0  # time without telemetry after which the pilot is warned
LATE = 2.5  # the same over a slow modem, in multiples of the last interval
QUIT_S = 3.0  # time limit for restoring the terminal
QUIT = ("\x03", "\x11")  # Ctrl-C, Ctrl-Q
INTERRUPTED = 130  # exit code, as for all commands
RED, YELLOW, DIM, RESET = "\x1b[1;37;41m", "\x1b[1;30;43m", "\x1b[2m", "\x1b[m"


class Screen(logging.Handler):
    """Shows a connection's readout, and passes keys to its hands; also shows logged warnings. name: the vehicle's."""

    def __init__(self, connection: Connection, name: str) -> None:
        super().__init__(logging.WARNING)
        self.connection, self.hands, self.vehicle = connection, connection.hands, name
        self.marks: list[str] = []
        self.code: int | None = None  # exit code, once the flight has ended
        self._log: deque[str] = deque(maxlen=100)
        self._last_text = ""
        self._error: Exception | None = None
        self._was_stopped: bool | None = None
        connection.report = self.report

    def run(self) -> int:
        """Fly until the pilot quits, a signal arrives or the terminal is gone. Return the exit code."""
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            signal.signal(number, lambda *_: self._end(INTERRUPTED))
        self.report("w s a d q e b space: drive   x X: all stop, its end   - =: effort   ?: all keys   Ctrl-Q: quit")
        last = threading.Timer(QUIT_S, os._exit, (INTERRUPTED,))
        last.daemon = True
        try:
            with Terminal() as terminal:
                self.connection.start()
                for act in (self._draw_on, self._read_on):
                    threading.Thread(target=self._end_after, args=(act, terminal), daemon=True).start()
                while self.code is None:
                    time.sleep(FRAME_S)
                self.connection.stop()
                last.start()  # the terminal may accept no more output
        finally:
            self.connection.stop()
        if self.code == 0:
            last.cancel()
        if self._error is not None:
            raise self._error
        return self.code

    def _end(self, code: int) -> None:
        self.code = code if self.code is None else self.code

    def _end_after(self, act: Callable[[Terminal], object], terminal: Terminal) -> None:
        try:
            act(terminal)
        except OSError:
            pass  # the terminal is gone
        except Exception as error:  # to be raised once the terminal is as before
            self._error = error
        self._end(INTERRUPTED)

    def _draw_on(self, terminal: Terminal) -> None:
        while self.code is None:
            size = shutil.get_terminal_size()
            terminal.show(self.lines(size.columns, size.lines))
            self.hands.beat()
            time.sleep(FRAME_S)

    def _read_on(self, terminal: Terminal) -> None:
        for key in terminal.typed():
            if key in QUIT:
                self._end(0)
            elif key == BLUR:
                self.hands.drop()
            else:
                self.press(key)

    def emit(self, record: logging.LogRecord) -> None:
        """Show a logged warning, since printing it would corrupt the screen."""
        self.report(record.getMessage())

    def report(self, text: str) -> None:
        """Show the pilot some text; may be called on any thread."""
        if text != self._last_text:
            self._last_text = text
            self._log.extend(f"{time.strftime('%H:%M:%S')} {text}".splitlines())

    def press(self, character: str) -> None:
        """Perform the action assigned to a character."""
        if character in SWITCHES:
            self.connection.do(SWITCHES[character])
        elif character in SERVICES:
            self.connection.call(SERVICES[character])
        elif character in (ALL_STOP, END_STOP):
            self.hands.press(ALL_STOP)
            self.connection.all_stop(on=character == ALL_STOP)
        elif character in STEPS:
            self.hands.change_share(STEPS[character])
        elif character == MARK:  # a function of the published keyboard, not a command
            readout = self.connection.readout
            self.marks.append(f"{readout.mission_s:.1f} s: {readout.place(2)}, {readout.depth_m:.2f} m deep")
            self.report(f"mark {len(self.marks)}: {self.marks[-1]}")
        elif character == HELP:
            self._last_text = ""
            self.report(HELP_TEXT)
        else:
            self.hands.press(character)

    def lines(self, columns: int, rows: int) -> list[str]:
        """Return what is shown, all stop first, so that no size of the terminal hides it."""
        is_stopped = self.connection.readout.all_stop
        if is_stopped and not self._was_stopped:
            self.hands.drop()  # so that a held key does not move the vehicle when all stop is released
        if self._was_stopped and is_stopped is False:
            self.connection.stop_is_wanted = False  # by another's release
        self._was_stopped = is_stopped
        warnings = wrap(_plain("  ".join(self._warnings())), columns)
        shown = [*map(_plain, self._numbers()), *(f"{RED}{line}{RESET}" for line in warnings)]
        log = [part for line in list(self._log) for part in wrap(_plain(line), columns)]
        room = max(rows - 1 - len(shown), 0)
        return [self.stop_line(), *shown, *log[len(log) - min(room, len(log)) :]][:rows]

    def stop_line(self) -> str:
        """Return all stop as far as it is known: set, asked for, or neither."""
        is_set = self.connection.readout.all_stop if self.connection.state == "connected" else None
        if is_set:
            return f"{RED}ALL STOP: X releases it{RESET}"
        if self.connection.stop_is_wanted:
            return f"{YELLOW}ALL STOP ASKED FOR, NOT CONFIRMED: X withdraws it{RESET}"
        return f"{DIM}{'all stop unknown' if is_set is None else 'no all stop'}: x sets it{RESET}"

    def _numbers(self) -> Iterator[str]:
        readout, hands = self.connection.readout, self.hands
        helm = "at the helm" if hands.has_helm else "helm free"
        yield f"{self.vehicle}   {self.connection.state}   {helm}   {hands.share:.0%} effort"
        yield (
            f"heading {_figure(readout.heading_deg)}°   depth {_figure(readout.depth_m, 1)} m   "
            f"altitude {_figure(readout.altitude_m, 1)} m   battery {_figure(readout.battery_percent)} %"
        )
        yield f"at      {readout.place(1)}"
        yield f"thrust  {_efforts(hands.efforts().values())}"
        yield f"applied {_efforts(readout.efforts)}"
        yield f"sonar   {readout.sonar_line()}"
        if readout.link:
            yield f"link    {readout.link}"

    def _warnings(self) -> Iterator[str]:
        connection = self.connection
        if connection.state != "connected":
            yield f"{connection.state.upper()}: {connection.url}"
        elif connection.silence_s > max(SILENT_S, LATE * connection.interval_s):
            yield f"NO TELEMETRY FOR {min(connection.silence_s, 999.0):.0f} s"
        yield from filter(None, (connection.readout.link_fault, *connection.readout.warnings))


def _figure(value: float, digits: int = 0) -> str:
    return ("beyond" if math.isinf(value) else "---" if math.isnan(value) else f"{value:.{digits}f}").rjust(5)


def _efforts(efforts: Iterable[float]) -> str:
    return "  ".join(f"{axis} {effort:+.2f}" for axis, effort in zip(AXES, efforts, strict=False)) or "---"


def _plain(text: str) -> str:
    """Return a text without what a terminal would obey."""
    return "".join(each if each.isprintable() else " " for each in text)


def fly(url: str, name: str, vehicle: str | None = None, *, adds_up: bool = False) -> tuple[list[str], int]:
    """Show the pilot's screen until the pilot quits. Return the marked positions and the exit code.

    The efforts are left at zero in all cases. adds_up: see Hands. Raises ValueError.
    """
    connection = Connection(url, Hands(adds_up=adds_up), vehicle)
    for each, stream in (("stdin", sys.stdin), ("stderr", sys.stderr)):  # where the terminal is read and written
        if not stream.isatty():
            raise ValueError(
                f"{each} is not a terminal: uwsim teleop needs one; without, see uwsim run and uwsim serve"
            )
    screen, root = Screen(connection, name), logging.getLogger()
    root.addHandler(screen)
    try:
        return screen.marks, screen.run()
    finally:
        root.removeHandler(screen)
