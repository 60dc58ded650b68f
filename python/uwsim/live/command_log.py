"""The log of all commands to a live simulator, by tick, and its replay."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base.commands import bound_command
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.scenario import Scenario
from uwsim.simulator.simulator import Simulator

ENTRIES_MAX = 1_000_000
PAYLOAD_BYTES_MAX = 256_000_000
CALL, RESET = "call", "reset"
PAYLOADS = {"link_send": "payload", SERVO_FRAMES: "frames"}


class Entry(NamedTuple):
    """A command and the tick at which it took effect, before the next step.

    name: one of COMMANDS; "reset", with the argument `state` (bytes, or None for the start); or "call", with the
    arguments `function` and `raised` (whether it raised an exception). Only the same process can repeat a call.
    """

    tick: int
    name: str
    arguments: dict[str, Any]


class CommandLog:
    """The entries of a live run, in the order in which they took effect, and its initial state.

    Commands that raised an error changed nothing and are not included. The log keeps the newest ENTRIES_MAX entries,
    and at most PAYLOAD_BYTES_MAX of link messages and autopilot frames. forgotten: the number of entries dropped.
    """

    def __init__(self, start_state: bytes, start_tick: int) -> None:
        self.start_state = start_state
        self.start_tick = start_tick
        self.forgotten = 0
        self._entries: deque[Entry] = deque()
        self._payload_bytes = 0

    def __repr__(self) -> str:
        return f"<CommandLog of {len(self)} commands from tick {self.start_tick}>"

    def append(self, entry: Entry) -> None:
        """Add an entry."""
        self._entries.append(entry)
        self._payload_bytes += _payload_bytes(entry)
        while len(self._entries) > ENTRIES_MAX or self._payload_bytes > PAYLOAD_BYTES_MAX:
            self._payload_bytes -= _payload_bytes(self._entries.popleft())
            self.forgotten += 1

    def __len__(self) -> int:
        return len(self._entries)

    def __iter__(self) -> Iterator[Entry]:
        """Return an iterator over a copy, since the log may grow during the iteration."""
        return iter(list(self._entries.copy()))


def _payload_bytes(entry: Entry) -> int:
    key = PAYLOADS.get(entry.name)
    return 0 if key is None else len(entry.arguments[key])


def replay(
    simulator: Simulator | str | Path | Scenario, log: CommandLog | Iterable[Entry], until_tick: int
) -> Simulator:
    """Replay a log; return the simulator at until_tick, in the same state as the original to the last bit.

    simulator: must have the same scenario, seed and build. A CommandLog starts from the initial state that it contains;
    other entries start from the simulator's current state. until_tick: not before the last entry. Raises ValueError if
    the log cannot be replayed.
    """
    sim = simulator if isinstance(simulator, Simulator) else Simulator(simulator)
    start = sim.save_state()
    if isinstance(log, CommandLog):
        if log.forgotten:
            raise ValueError(f"log: its first {log.forgotten} entries have been discarded: it cannot be replayed")
        start = log.start_state
        sim.restore_state(start)
    for entry in log:
        _advance_to(sim, entry.tick)
        _repeat(sim, entry, start)
    _advance_to(sim, until_tick)
    return sim


def _repeat(sim: Simulator, entry: Entry, start: bytes) -> None:
    if entry.name == RESET:
        state = entry.arguments["state"]
        sim.restore_state(start if state is None else state)
    elif entry.name == CALL:
        try:
            entry.arguments["function"](sim)
        except Exception:
            if not entry.arguments["raised"]:
                raise
    else:
        bound_command(entry.name, entry.arguments)(sim)


def _advance_to(sim: Simulator, tick: int) -> None:
    if tick < sim.tick:
        raise ValueError(f"log: tick {tick} is before tick {sim.tick}: entries must be in order")
    sim.step(tick - sim.tick)
