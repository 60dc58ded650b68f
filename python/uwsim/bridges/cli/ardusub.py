"""`uwsim ardusub`: a compiled ArduSub flies a scenario's vehicle, from nothing to flight."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.bridges.ardusub.options import ProgramOptions
from uwsim.bridges.cli.serve import Speed, parsed_speed
from uwsim.cli.groups import under
from uwsim.cli.options import Seed, Threads
from uwsim.cli.values import scenarios
from uwsim.recording.flight_options import RecordOptions


@under("Connect")
def ardusub(
    *,
    binary: Annotated[Path, typer.Argument(help="ArduSub, compiled for simulation (SITL).", show_default=False)],
    scenario: Annotated[
        str, typer.Option(help="Name of a packaged scenario, or path of a YAML file.", autocompletion=scenarios)
    ] = "lagoon",
    program: ProgramOptions,
    speed: Speed = "1",
    seed: Seed = None,
    recorded: RecordOptions,
    threads: Threads = None,
) -> None:
    """Start a compiled ArduSub, which flies a vehicle.

    A ground station finds it at UDP 14550.

    The program navigates by the vehicle's own instruments, without GPS. Ctrl-C ends both. For ROS and pages beside it,
    give `--ardusub --ardusub-binary` to `uwsim serve`.
    """
    from contextlib import ExitStack

    from uwsim.bridges.firmware.firmware import checked_program
    from uwsim.cli.autopilots import prepared
    from uwsim.cli.run_live import run_until_interrupted
    from uwsim.live import LiveSimulator

    pace = parsed_speed(speed)
    autopilot = program.of(checked_program(binary))
    simulator = prepared(autopilot, scenario, seed=seed, threads=threads)
    model = simulator.scenario.vehicles[0].model.name
    with ExitStack() as stack:
        live = LiveSimulator(simulator, speed=pace)
        flown = stack.enter_context(autopilot.flying(live))
        stack.enter_context(live)
        if recorded.record is not None:
            from uwsim.recording import Recorder

            stack.enter_context(Recorder(live, recorded.record, topics=recorded.record_topic or None, is_light=True))
        run_until_interrupted(live, f"{scenario} with {model}, {flown}", ends_with_error=True)
