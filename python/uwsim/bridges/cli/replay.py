"""`uwsim replay`: repeat a recorded run and compare it, or play its messages to clients of bridges."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import need, refuse
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.requested import PlayedBridges
from uwsim.cli.access import Access
from uwsim.cli.exit_codes import FAILED, INCOMPLETE
from uwsim.cli.groups import under
from uwsim.cli.options import AsJson, Threads, print_json
from uwsim.cli.values import readable, within, writable
from uwsim.recording.cli.real_flight import LogColumns, LogOutputs


@under("Record")
def replay(
    *,
    recording: Annotated[
        Path,
        typer.Argument(
            help="A recording, FILE.mcap; with --beside or --as-recording a log of others: .BIN, .tlog, a ROS bag, a "
            "table.",
            metavar="FILE",
            callback=readable,
        ),
    ],
    from_s: Annotated[
        float, typer.Option("--from", help="Simulated time to begin at [s].", callback=within(0, 1e9, "s"))
    ] = 0.0,
    until_s: Annotated[
        float | None, typer.Option("--until", help="Simulated time to end at [s].", callback=within(0, 1e9, "s"))
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(help="Simulated seconds per wall second, or max. Default: max; 1 with --as-topics."),
    ] = None,
    as_topics: Annotated[
        bool, typer.Option("--as-topics", help="Do not simulate: play the recorded messages to clients.")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(
            help=f"With --as-topics: where to listen; 0 chooses a free port. Default: {ROSBRIDGE_PORT}.",
            callback=within(0, 65535),
        ),
    ] = None,
    host: Annotated[
        str | None, typer.Option(help="With --as-topics: address to listen on. Default: 127.0.0.1.")
    ] = None,
    wait: Annotated[
        bool, typer.Option("--wait", help="With --as-topics: begin when the first client connects.")
    ] = False,
    beside: Annotated[
        str | None,
        typer.Option(help="Fly the model of this vehicle, a name or a YAML file, beside the log of a real flight."),
    ] = None,
    as_recording: Annotated[
        Path | None,
        typer.Option(
            help="Write a recording, a new .mcap, of a vehicle that is placed along the log of a real flight.",
            callback=writable,
        ),
    ] = None,
    scenario: Annotated[
        str | None, typer.Option(help="With --as-recording: where; its first vehicle is placed. Default: lake.")
    ] = None,
    columns: LogColumns = None,
    outputs: LogOutputs = None,
    density: Annotated[
        float | None,
        typer.Option(
            help="With --beside: density of the water [kg/m3]. Default: 1000.", callback=within(900, 1100, "kg/m3")
        ),
    ] = None,
    bridges: PlayedBridges,
    access: Access,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Repeat a recorded run and compare every message.

    The run is flown again with its scenario, seed and commands, and must produce the same bytes. Reports the first
    difference and exits with 1, also for a damaged file; exits with 4 if everything is equal up to the point where the
    recording was cut off. With --as-topics nothing is simulated: the messages are played back to clients of rosbridge,
    ROS 2, ROS 1 and Foxglove.

    With --beside, the file is the log of a real flight. Prints what the log has, lacks and leaves to assumptions, then
    flies the vehicle's model beside it, with the log's commands: from the log's motion at many times, for 1, 2, 5, 10
    and 30 s, at whose end the model's error is measured. Means have 95 % intervals.

    With --as-recording, the file is such a log, too. The scenario's first vehicle is placed along it five times a
    second, and the recording opens like that of any other flight: at the station, in `film` and in `replay`.
    """
    from uwsim.bridges.cli.serve import parsed_speed
    from uwsim.recording.reader import Recording
    from uwsim.recording.replay import Pacer

    if not 0.0 <= from_s <= (from_s if until_s is None else until_s):  # also false for NaN
        raise ValueError(f"--from {from_s:g} s, --until {until_s} s: must be 0 or more, and in this order")
    if beside is not None or as_recording is not None:
        vain = f"without effect with {'--beside' if beside is not None else '--as-recording'}"
        refuse(vain, as_topics=as_topics, speed=speed, port=port, host=host, wait=wait)
        refuse(vain, **{"from": from_s or None, "until": until_s})
        refuse(vain, **dict.fromkeys(bridges.names, True), **access.given())
    if as_recording is not None:
        refuse("without effect with --as-recording", beside=beside, outputs=outputs, density=density)
        _record(recording, as_recording, scenario or "lake", columns, threads, as_json=as_json)
        return
    need("--as-recording", scenario=scenario)
    if beside is not None:
        _fly_beside(recording, beside, columns, outputs, density, threads, as_json=as_json)
        return
    need("--beside", columns=columns, outputs=outputs, density=density)
    if as_topics:
        need("a replay without --as-topics", threads=threads, json=as_json or None)
    else:
        need("--as-topics", port=port, host=host, wait=wait, **dict.fromkeys(bridges.names, True))
        need("--as-topics", **access.given())
    accessible = access.settings(host or "127.0.0.1")
    if as_topics and speed == "max":
        raise ValueError("--speed max: with --as-topics it must be a factor: clients could not follow")
    bridges.prepare()
    pacer = Pacer(parsed_speed(speed or ("1" if as_topics else "max")))
    opened = Recording(recording)
    if as_topics:
        from uwsim.bridges.playback.playback import play

        play(
            opened, pacer, port=ROSBRIDGE_PORT if port is None else port, from_s=from_s, until_s=until_s, wait=wait,
            bridges=bridges, say=typer.echo, **accessible,
        )  # fmt: skip
        return
    from uwsim.recording.replay import replay as repeat

    result = repeat(opened, from_s=from_s, until_s=until_s, threads=threads, on_time=pacer.wait)
    if not opened.complete:
        where = "" if opened.end_tick is None else f" at {opened.end_tick * 1e-9 * opened.step_ns:g} s"
        typer.echo(f"{recording}: was cut off{where}, as by a kill; its messages up to there are compared", err=True)
    for topic, count in sorted(result.left_out.items()):
        typer.echo(f"/{topic}: {count} messages are not in the recording", err=True)
    if as_json:
        print_json({
            "same": result.difference is None, "difference": result.difference, "whole": opened.complete,
            "channels": {f"/{name}": count for name, count in result.messages.items()}, "commands": result.commands,
            "state_compared": result.state_compared, "left_out": {f"/{k}": n for k, n in result.left_out.items()},
            "not_compared": result.not_compared, "to_s": result.sim.time_s,
        })  # fmt: skip
    if result.difference is not None:
        if not as_json:
            typer.echo(f"not the same: {result.difference}")
        raise typer.Exit(FAILED)
    if not result.messages and not result.state_compared:
        typer.echo(f"{recording}: nothing was compared: no message of the replay is in it", err=True)
        raise typer.Exit(FAILED)
    if result.not_compared:
        typer.echo(f"not compared: {', '.join(result.not_compared)}", err=True)
    if not as_json:
        state = " and the state at the end" if result.state_compared else ""
        typer.echo(
            f"the same bytes: {result.messages.total():,} messages of {len(result.messages)} channels{state}, "
            f"{result.commands:,} commands, until {result.sim.time_s:g} s"
        )
    if not opened.complete:
        raise typer.Exit(INCOMPLETE)


def _record(path: Path, out: Path, scenario: str, columns: str | None, threads: int | None, *, as_json: bool) -> None:
    from uwsim.recording.real_flights.as_recording import record_log
    from uwsim.recording.real_flights.read import read_flight
    from uwsim.simulator.simulator import Simulator

    log = read_flight(path, columns)
    notes = [str(note) for note in log.notes() + record_log(log, Simulator(scenario, threads=threads), out)]
    if as_json:
        print_json({"notes": notes, "recording": str(out)})
        return
    typer.echo("\n".join([*notes, f"{out}: written"]))


def _fly_beside(
    path: Path,
    vehicle: str,
    columns: str | None,
    outputs: str | None,
    density: float | None,
    threads: int | None,
    *,
    as_json: bool,
) -> None:
    from uwsim.recording.real_flights.beside import fly_beside
    from uwsim.recording.real_flights.motion import motion_of
    from uwsim.recording.real_flights.read import read_flight
    from uwsim.scenario import load_vehicle

    model = load_vehicle(vehicle)
    log = read_flight(path, columns)
    notes = [str(note) for note in log.notes()]
    if not as_json:
        typer.echo("\n".join(notes))
    motion, more = motion_of(log, model, outputs)
    result = fly_beside(motion, model, density_kg_m3=1000.0 if density is None else density, threads=threads)
    others = [str(note) for note in (*more, *result.notes)]
    if as_json:
        print_json({"notes": [*notes, *others], "horizons": result.plain()})
        return
    typer.echo("\n".join(others))
    rows = result.rows()
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        typer.echo("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
