"""`uwsim recording`: list a recording's contents."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.groups import with_default
from uwsim.cli.options import AsJson, print_json
from uwsim.cli.values import readable

app = with_default("recording", "List the contents of a recording; compare two; film one.", "Record")


@app.command("info")
def recording(
    source: Annotated[Path, typer.Argument(help="A recording.", metavar="FILE.mcap", callback=readable)],
    as_json: AsJson = False,
) -> None:
    """List the contents of a recording: run, commands, channels."""
    from uwsim.recording.commands import COMMANDS
    from uwsim.recording.reader import Recording

    run = Recording(source)
    first_s = run.start.tick * 1e-9 * run.step_ns
    end = "and was cut off at once" if run.end_tick is None else f"to {run.end_tick * 1e-9 * run.step_ns:g} s"
    if run.end is None and run.end_tick is not None:
        end += ", where it was cut off"
    commands = Counter(command.name for command in run.commands()) if COMMANDS in run.channels else Counter()
    if as_json:
        print_json({
            "kind": run.start.kind, "scenario": run.start.scenario, "seed": run.start.seed, "from_s": first_s,
            "to_s": None if run.end_tick is None else run.end_tick * run.step_ns / 1e9, "is_whole": run.end is not None,
            "begun": run.start.begun, "build": run.start.build, "bytes": source.stat().st_size,
            "commands": dict(commands), "left_out": dict(run.dropped),
            "channels": {
                f"/{each.name}": {"type": each.type, "messages": each.message_count, "rate_hz": each.rate_hz}
                for each in run.channels.values()
            },
        })  # fmt: skip
        return
    rows = [
        ("run", f"{run.start.kind}, scenario {run.start.scenario}, seed {run.start.seed}"),
        ("simulated", f"from {first_s:g} s {end}"),
        ("begun", run.start.begun),
        ("build", run.start.build),
        ("size", f"{1e-6 * source.stat().st_size:.1f} MB"),
        ("commands", ", ".join(f"{count} {name}" for name, count in commands.most_common()) or "none"),
        ("left out", ", ".join(f"{count} /{name}" for name, count in run.dropped.items()) or "none"),
    ]
    for name, value in rows:
        typer.echo(f"{name:<10}{value}")
    width = max((len(name) for name in (*run.channels, *run.derived)), default=0)
    for info in (*run.channels.values(), *run.derived.values()):
        rate = f"{info.rate_hz:g} Hz" if info.rate_hz else ""
        made = "  (from /sonar_ping)" if info.name in run.derived else ""
        typer.echo(f"{info.message_count:>8}  /{info.name:<{width}}  {rate:>7}  {info.type}{made}")
