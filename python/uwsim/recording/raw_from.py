"""Writes a raw survey of a recorded run that has to be repeated for it: what its messages alone do not hold."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from uwsim import _core
from uwsim.base.journal import JUMPS
from uwsim.flight.patch_errors import PatchErrors
from uwsim.flight.raw_survey import raw_writer
from uwsim.recording.ping_channel import NAME
from uwsim.recording.pings import recorded_pings
from uwsim.recording.reader import Recording
from uwsim.recording.replay import execute, new_simulator
from uwsim.scoring.tpu import Uncertainties
from uwsim.simulator.simulator import Simulator


def raw_from(
    recording: Recording, topic: str, raw: Path, errors: PatchErrors | None = None, known: Uncertainties | None = None
) -> int:
    """Repeat a run, write its raw survey as in the flight at the times of the pings on a channel; return their number.

    See `raw_writer`. Raises ValueError, also if this build does not repeat the run, or OSError.
    """
    sim = new_simulator(recording)
    if topic not in (NAME, f"{sim.rov.name}/{NAME}"):
        raise ValueError(f"--raw {raw}: is of the first vehicle, '{sim.rov.name}', whose pings are not on {topic}")
    writer = raw_writer(sim, raw, errors, known)
    try:
        for ping in _repeated(recording, sim, topic):
            writer.add(ping, None, np.asarray(sim.rov.pose.world_from_body, np.float64))
        writer.close()
    except BaseException:
        writer.discard()
        raise
    return writer.count


def _repeated(recording: Recording, sim: Simulator, topic: str) -> Iterator[_core.Ping]:
    """Yield the pings of a channel, taken again at the time of each, before its commands."""
    commands = iter(recording.commands())
    command, last = next(commands, None), -1
    for taken, _ in recorded_pings(recording, topic):
        tick = taken.ping.time_ns // recording.step_ns
        while command is not None and command.tick < tick:
            if command.name in JUMPS:
                reason = "its time was reset, at which a raw survey ends"
                raise ValueError(f"recording '{recording.path}': tick {command.tick}: {reason}")
            _step_to(sim, command.tick)
            execute(sim, None, command)
            command = next(commands, None)
        if tick == last:  # a live run's channel may say the latest ping again
            continue
        _step_to(sim, tick)
        last = tick
        ping = sim.rov.sonar.ping()
        if not np.array_equal(ping.ranges_m, taken.ping.ranges_m, equal_nan=True):
            raise ValueError(f"recording '{recording.path}': tick {tick}: this build of uwsim does not repeat the ping")
        yield ping


def _step_to(sim: Simulator, tick: int) -> None:
    if tick > sim.tick:
        sim.step(tick - sim.tick)
