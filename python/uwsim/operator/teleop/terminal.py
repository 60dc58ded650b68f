"""Reports key releases from terminals with the kitty keyboard protocol, which textual does not request.

See https://sw.kovidgoyal.net/kitty/keyboard-protocol/. With the protocol's flag 2, a key event states whether the key
was pressed (1), has repeated (2) or was released (3): `CSI code ; modifiers : event ; text u`.
"""

from __future__ import annotations

import os
import re
import selectors
from codecs import getincrementaldecoder
from collections.abc import Callable, Iterable

from textual import events
from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.message import Message

REPORT_EVENTS = "\x1b[=2;2u"  # set flag 2 in addition to those already set
EVENT = re.compile(
    r"\x1b\[(?P<code>\d+)(?P<others>:[\d:]*)?;(?P<modifiers>\d*):(?P<event>[123])(?P<rest>(?:;[\d:]*)?[u~ABCDEFHPQRS])"
)
LET_GO = "3"


class KeyReleased(Message):
    """A message that a key was released. character: the character of the key without modifiers."""

    def __init__(self, character: str) -> None:
        super().__init__()
        self.character = character


class ReleaseParser(XTermParser):
    """Reports key releases through a callback. Presses and repeats are handled as in textual."""

    def __init__(self, released: Callable[[str], object]) -> None:
        super().__init__()
        self._released = released

    def _sequence_to_key_events(self, sequence: str, alt: bool = False) -> Iterable[events.Key]:
        match = EVENT.fullmatch(sequence)
        if match is None:
            return super()._sequence_to_key_events(sequence, alt)
        if match["event"] == LET_GO:
            if match["rest"].endswith("u"):  # not an arrow or function key
                self._released(chr(int(match["code"])))
            return [events.Key("<ignore>", None)]
        plain = f"\x1b[{match['code']}{match['others'] or ''};{match['modifiers'] or '1'}{match['rest']}"
        return super()._sequence_to_key_events(plain, alt)


class ReleaseDriver(LinuxDriver):
    """Textual's driver for Linux and macOS, which also posts KeyReleased."""

    def start_application_mode(self) -> None:
        """Also request releases. Terminals without support ignore this."""
        super().start_application_mode()  # type: ignore[no-untyped-call]
        self.write(REPORT_EVENTS)
        self.flush()

    def run_input_thread(self) -> None:
        """Read the terminal until the application ends."""
        parser = ReleaseParser(lambda character: self.process_message(KeyReleased(character)))
        decode = getincrementaldecoder("utf-8")(errors="replace").decode
        with selectors.DefaultSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                if selector.select(0.1):
                    if not (data := _read(self.fileno)):  # the terminal is gone
                        self._app.call_later(self._app.exit)
                        return
                    for message in parser.feed(decode(data)):
                        self.process_message(message)
                for message in parser.tick():
                    self.process_message(message)


def _read(descriptor: int) -> bytes:
    try:
        return os.read(descriptor, 4096)
    except OSError:
        return b""
