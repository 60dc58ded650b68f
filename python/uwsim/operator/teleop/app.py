"""The pilot's terminal: one line with all stop, numbers and state, messages above it. It passes keys to the hands."""

from __future__ import annotations

import logging
import os
import re
import shutil
import signal
import sys
import termios
import threading
import time
import tty
from collections import deque
from collections.abc import Iterator
from contextlib import suppress

from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.hands import ALL_STOP, END_STOP, HELP, HELP_TEXT, SERVICES, SWITCHES

FRAME_S = 0.1
SILENT_S = 1.0  # time without telemetry after which the pilot is warned
LATE = 2.5  # the same over a slow modem, in multiples of the last interval
QUIT_S = 3.0  # time limit for restoring the terminal
QUIT = ("\x03", "\x11")  # Ctrl-C, Ctrl-Q
INTERRUPTED = 130  # exit code, as for all commands
BLUR = "\x1b[O"  # sent by a terminal that loses focus, once asked to
FOCUS, NO_FOCUS = b"\x1b[?1004h", b"\x1b[?1004l\r\n"
KEY = re.compile(r"\x1b\[[\d:;<=>?]*[@-~]|[^\x1b]", re.DOTALL)
"""An escape sequence, such as an arrow key's, or a character. An escape alone is no key, and what follows it is one."""
RED, YELLOW, RESET = "\x1b[1;37;41m", "\x1b[1;30;43m", "\x1b[m"


class _Ended(BaseException):
    """Ends the main thread's drawing, also while the terminal accepts no output."""


class Screen(logging.Handler):
    """Shows a connection's readout, and passes keys to its hands; also shows logged warnings."""

    def __init__(self, connection: Connection) -> None:
        super().__init__(logging.WARNING)
        self.connection, self.hands = connection, connection.hands
        self.said: deque[str] = deque(maxlen=100)  # not shown yet
        self._code = INTERRUPTED
        self._last_text = self._warnings = ""
        self._error: Exception | None = None
        self._has_ended, self._was_stopped = False, False
        connection.report = self.report

    def run(self) -> int:
        """Fly until the pilot quits, a signal arrives or the terminal is gone. Return the exit code.

        The efforts are left at zero in all cases. Raises ValueError without a terminal.
        """
        for name in ("stdin", "stderr"):  # where the terminal is read and written
            if not getattr(sys, name).isatty():
                rule = "uwsim teleop needs one; without, see uwsim run and uwsim serve"
                raise ValueError(f"{name} is not a terminal: {rule}")
        logging.getLogger().addHandler(self)
        self.report(HELP_TEXT)
        last = threading.Timer(QUIT_S, os._exit, (INTERRUPTED,))
        last.daemon = True
        before = termios.tcgetattr(sys.stdin)
        try:
            for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
                signal.signal(number, self._end)
            tty.setraw(sys.stdin, termios.TCSANOW)
            _write(FOCUS)
            self.connection.start()
            threading.Thread(target=self._read, args=(threading.get_ident(),), daemon=True).start()
            while True:
                _write(self.text(shutil.get_terminal_size().columns).encode(errors="replace"))
                self.hands.beat()
                time.sleep(FRAME_S)
        except (_Ended, OSError):  # OSError: the terminal is gone
            pass
        finally:
            self._has_ended = True
            self.connection.stop()
            last.start()  # the terminal may accept no more output
            with suppress(OSError, termios.error):
                termios.tcsetattr(sys.stdin, termios.TCSANOW, before)
                _write(NO_FOCUS)
        if self._code == 0:
            last.cancel()
        if self._error is not None:
            raise self._error
        return self._code

    def _end(self, number: int, frame: object) -> None:
        if not self._has_ended:
            self._has_ended = True
            raise _Ended

    def _read(self, main: int) -> None:
        """Pass on the keys that the pilot types until the terminal is gone, then end the main thread."""
        try:
            while data := os.read(sys.stdin.fileno(), 4096):
                for key in KEY.findall(data.decode("ascii", "ignore")):
                    if key in QUIT:
                        self._code = 0
                        return
                    self.press(key)
        except OSError:
            pass  # the terminal is gone
        except Exception as error:  # to be raised once the terminal is as before
            self._error = error
        finally:
            signal.pthread_kill(main, signal.SIGTERM)

    def emit(self, record: logging.LogRecord) -> None:
        """Show a logged warning, since printing it would corrupt the line."""
        self.report(record.getMessage())

    def report(self, text: str) -> None:
        """Show the pilot some text; may be called on any thread."""
        if text != self._last_text:
            self._last_text = text
            self.said.extend(f"{time.strftime('%H:%M:%S')} {text}".splitlines())

    def press(self, key: str) -> None:
        """Perform the action assigned to a key."""
        if key in SWITCHES:
            self.connection.do(SWITCHES[key])
        elif key in SERVICES:
            self.connection.call(SERVICES[key])
        elif key in (ALL_STOP, END_STOP):
            self.hands.press(ALL_STOP)
            self.connection.all_stop(on=key == ALL_STOP)
        elif key == HELP:
            self._last_text = ""
            self.report(HELP_TEXT)
        elif key == BLUR:
            self.hands.drop()
        else:
            self.hands.press(key)

    def text(self, columns: int) -> str:
        """Return what is shown next: messages, then the line, which begins with all stop and takes one row."""
        connection, is_stopped = self.connection, self.connection.readout.all_stop
        if is_stopped and not self._was_stopped:
            self.hands.drop()  # so that a held key does not move the vehicle when all stop is released
        if self._was_stopped and is_stopped is False:
            connection.stop_is_wanted = False  # by another's release
        self._was_stopped = bool(is_stopped)
        warnings = ", ".join(self._lit())
        if warnings != self._warnings:
            self._warnings = warnings
            self.report(f"warnings: {warnings or 'none'}")
        stop, colour = self.stop(RED if warnings else "")
        lag = f"{min(connection.silence_s, 999.0):.1f} s"
        helm = f"{'helm' if self.hands.has_helm else 'free'} {self.hands.share:.0%}"
        line = f"{stop}  {connection.readout.numbers}  lag {lag}  {helm}  {connection.state}"
        rest = f"  {connection.readout.link}  {warnings}"
        said = "".join(f"{_plain(self.said.popleft())}\r\n" for _ in range(len(self.said)))
        return f"\r\x1b[K{said}{colour}{_plain(line + rest)[: max(columns - 1, 0)].rstrip()}{RESET}"

    def stop(self, colour: str) -> tuple[str, str]:
        """Return all stop as far as it is known: set, asked for, or neither; and its colour, or the one given."""
        is_set = self.connection.readout.all_stop if self.connection.state == "connected" else None
        if is_set:
            return "ALL STOP: X releases it", RED
        if self.connection.stop_is_wanted:
            return "ALL STOP NOT CONFIRMED: X withdraws it", YELLOW
        return "all stop unknown" if is_set is None else "no all stop", colour

    def _lit(self) -> Iterator[str]:
        connection = self.connection
        if connection.state != "connected":
            yield f"{connection.state.upper()}: {connection.url}"
        elif connection.silence_s > max(SILENT_S, LATE * connection.interval_s):
            yield "NO TELEMETRY"
        yield from filter(None, (connection.readout.link_fault, *connection.readout.warnings))


def _plain(text: str) -> str:
    """Return a text without what a terminal would obey."""
    return "".join(each if each.isprintable() else " " for each in text)


def _write(data: bytes) -> None:
    while data:
        data = data[os.write(sys.stderr.fileno(), data) :]
