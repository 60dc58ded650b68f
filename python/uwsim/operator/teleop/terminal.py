"""The pilot's terminal: it reports keys and shows lines, by escape sequences that all terminals know."""

from __future__ import annotations

import os
import re
import sys
import termios
import tty
from collections.abc import Iterator, Sequence

START = "\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[?1004h"  # a screen of its own, no cursor, no wrapping, reports of focus
END = "\x1b[?1004l\x1b[?7h\x1b[?25h\x1b[?1049l"
BLUR = "\x1b[O"  # sent by a terminal that loses focus
KEY = re.compile(r"\x1b\[[\d:;<=>?]*[@-~]|[^\x1b]", re.DOTALL)
"""An escape sequence, such as an arrow key's, or a character. An escape alone is no key, and what follows it is one."""


class Terminal:
    """The terminal of this process, in raw mode within a `with` block."""

    def __enter__(self) -> Terminal:
        self._before = termios.tcgetattr(sys.stdin)
        tty.setraw(sys.stdin, termios.TCSANOW)
        self._write(START)
        return self

    def __exit__(self, *_: object) -> None:
        termios.tcsetattr(sys.stdin, termios.TCSANOW, self._before)
        self._write(END)

    def typed(self) -> Iterator[str]:
        """Yield the keys that the pilot types, until the terminal is gone."""
        while data := os.read(sys.stdin.fileno(), 4096):
            yield from KEY.findall(data.decode("ascii", "ignore"))

    def show(self, lines: Sequence[str]) -> None:
        """Replace what is shown."""
        self._write("\x1b[H" + "\x1b[K\r\n".join(lines) + "\x1b[K\x1b[J")

    def _write(self, text: str) -> None:
        data = text.encode(errors="replace")
        while data:
            data = data[os.write(sys.stderr.fileno(), data) :]
