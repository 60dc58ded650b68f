"""Joins an autopilot's frames, which arrive in pieces set by the wall clock, into pieces that end at set ticks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from uwsim.simulator.lockstep import FRAME_BYTES

PIECE_TICKS = 400
"""A piece ends at a multiple of this many ticks at the latest."""


class JoinedFrames:
    """The frames that wait, by vehicle: the arguments of the command `servo_frames`."""

    def __init__(self) -> None:
        self._waiting: dict[str, dict[str, Any]] = {}

    def add(self, arguments: dict[str, Any]) -> Iterator[dict[str, Any]]:
        """Add the arguments of a command, and yield those of all pieces that are complete."""
        waiting = self._waiting.pop(arguments["vehicle"], None)
        if waiting is not None and arguments == {
            **waiting, "from_tick": end_tick(waiting), "frames": arguments["frames"]
        }:  # fmt: skip
            arguments = {**waiting, "frames": waiting["frames"] + arguments["frames"]}
        elif waiting is not None:
            yield waiting
        while (count := PIECE_TICKS - int(arguments["from_tick"]) % PIECE_TICKS) <= _count(arguments):
            frames, at = arguments["frames"], count * FRAME_BYTES
            yield {**arguments, "frames": frames[:at]}
            arguments = {**arguments, "from_tick": arguments["from_tick"] + count, "frames": frames[at:]}
        if arguments["frames"]:
            self._waiting[arguments["vehicle"]] = arguments

    def taken(self) -> Iterator[dict[str, Any]]:
        """Yield what waits, if anything, which then waits no longer."""
        waiting, self._waiting = self._waiting, {}
        yield from waiting.values()


def end_tick(arguments: dict[str, Any]) -> int:
    """Return the tick at which the last of the frames has been made."""
    return int(arguments["from_tick"]) + _count(arguments)


def _count(arguments: dict[str, Any]) -> int:
    return len(arguments["frames"]) // FRAME_BYTES
