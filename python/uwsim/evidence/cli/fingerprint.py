"""`uwsim scenario fingerprint`: a hash of everything that a short run produces, for comparing machines."""

from __future__ import annotations

import typer

from uwsim.cli.options import AsJson, ScenarioName, Seed, Threads, print_json


def fingerprint(
    scenario: ScenarioName = "lake",
    seed: Seed = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Fly for a few seconds and print a hash of all results.

    Hashes poses, samples, pings in both modes, pictures and maps; prints the properties of the machine that may matter.
    Two machines that print the same last line for the same scenario and seed produce the same results; if it differs,
    the lines before it show which results differ. The environment variable UWSIM_INSTRUCTION_SET=portable, avx2 or
    avx512 makes the results of different kinds of processor identical.
    """
    from uwsim.evidence.fingerprint import fingerprint as made

    found = made(scenario, seed=seed, threads=threads)
    if as_json:
        print_json({
            "scenario": found.scenario,
            "seed": found.seed,
            "whole": found.whole,
            "parts": found.parts,
            "machine": found.machine,
        })  # fmt: skip
        return
    width = max(map(len, (*found.machine, *found.parts)))
    for title, rows in (
        ("Results may depend on", {"scenario": found.scenario, "seed": found.seed, **found.machine}),
        ("Hashes of the results", {**found.parts, "all": found.whole}),
    ):
        typer.echo(f"{title}:")
        for name, value in rows.items():
            typer.echo(f"  {name:<{width}}  {value}")
