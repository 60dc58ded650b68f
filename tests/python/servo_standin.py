"""A stand-in for a compiled ArduSub: the autopilot's end of ArduPilot's JSON interface, for tests."""

from __future__ import annotations

import json
import socket
import struct
import threading
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

from uwsim.recording.real_flights.frames import FRAMES

NEUTRAL, SPAN = 1500, 400
REPEAT_S = 0.2  # ArduSub: 1 s
Decide = Callable[[dict[str, Any]], Sequence[int]]
"""Returns the pulse widths [us] of the next frame from the last line; {} before the first."""


def mixed(frame: str, **demands: float) -> list[int]:
    """Return the pulse widths [us] for demands such as forward=0.5, mixed by the frame's own factors."""
    totals = [sum(getattr(motor, name) * value for name, value in demands.items()) for motor in FRAMES[frame]]
    return [round(NEUTRAL + SPAN * total) for total in totals]


def packet(number: int, outputs_us: Sequence[int], rate_hz: int = 400) -> bytes:
    """Return a servo packet, of 16 channels, or of 32 if there are more outputs."""
    channels = 16 if len(outputs_us) <= 16 else 32
    padded = [*outputs_us, *[0] * (channels - len(outputs_us))]
    return struct.pack(f"<HHI{channels}H", 18458 if channels == 16 else 29569, rate_hz, number, *padded)


class Standin:
    """Sends a frame and waits for the line, again and again, on its own thread; it repeats a frame after REPEAT_S.

    lines: those received; of several, only each `every`th is read.
    """

    def __init__(self, port: int, decide: Decide, frames: int = 2**31, every: int = 1) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._socket.settimeout(REPEAT_S)
        self._decide, self._frames, self._every = decide, frames, every
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self.lines: list[dict[str, Any]] = []

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ends.set()
        self._thread.join(3)
        self._socket.close()

    def _run(self) -> None:
        state: dict[str, Any] = {}
        for number in range(self._frames):
            frame = packet(number, self._decide(state))
            while not self._ends.is_set():
                try:
                    self._socket.send(frame)
                    line = self._socket.recv(2000)
                    if (number + 1) % self._every == 0:
                        state = json.loads(line)
                        self.lines.append(state)
                    break
                except TimeoutError:
                    continue
                except ConnectionRefusedError:  # nothing listens yet
                    time.sleep(0.02)
            if self._ends.is_set():
                return
