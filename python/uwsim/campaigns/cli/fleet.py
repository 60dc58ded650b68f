"""`uwsim fleet`: survey a large area in tiles, on many workers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.campaigns.workers.options import RetriedOptions
from uwsim.cli.exit_codes import FAILED, INTERRUPTED
from uwsim.cli.groups import under
from uwsim.cli.options import ScenarioName, Seed, Voxel
from uwsim.cli.values import within

if TYPE_CHECKING:
    from uwsim.campaigns.fleet import Fleet


@under("Fly")
def fleet(
    *,
    scenario: ScenarioName,
    tile: Annotated[float, typer.Option(help="Largest edge of a tile [m].", callback=within(1, 1e5, "m"))],
    out: Annotated[Path, typer.Option(help="Folder for map.bt, summary.json, tiles.png and the tiles' maps.")] = Path(
        "fleet"
    ),
    voxel: Voxel = None,
    seed: Seed = None,
    vehicles: Annotated[
        int,
        typer.Option(
            help="Vehicles that share the tiles: determines the fleet's time at sea, not the map.",
            callback=within(1, 100_000),
        ),
    ] = 1,
    score: Annotated[bool, typer.Option("--score/--no-score", help="Compare the map with the true world.")] = True,
    work: RetriedOptions,
) -> None:
    """Survey an area in tiles on many workers; merge the maps.

    Each tile is surveyed by a separate vehicle, and the whole map is scored. A worker builds only its tile's part of
    the terrain, so the area may exceed the memory of one process. The bytes of the map do not depend on the number of
    workers or the order in which tiles are finished. If the fleet is interrupted or
    killed, only the tiles in progress are lost: --resume flies the rest. Exits with 1 if a tile failed.
    """
    from uwsim.campaigns.fleet import run_fleet
    from uwsim.campaigns.workers.job_progress import job_progress

    with job_progress("tiles") as progress:
        flown = run_fleet(
            scenario, out, tile_m=tile, voxel_m=voxel, seed=seed, vehicles=vehicles, score=score, **work.arguments,
            **progress.arguments,
        )  # fmt: skip
    for number, error in list(flown.failed.items())[:3]:
        typer.echo(f"tile {number}: {error}", err=True)
    for number, reason in list(flown.ended_early.items())[:3]:
        typer.echo(f"tile {number} ended early: {reason}", err=True)
    if flown.interrupted:
        done = f"{len(flown.results):,} of {len(flown.tiles):,} tiles"
        typer.echo(f"interrupted after {done}; --resume continues", err=True)
        raise typer.Exit(INTERRUPTED)
    _print(flown)
    if flown.failed:
        raise typer.Exit(FAILED)


def _print(flown: Fleet) -> None:
    from uwsim.flight.summary import duration_text

    of = flown.figures
    rows = [
        (
            "tiles",
            f"{of['tiles_flown']:,} flown, {of['tiles_ended_early']:,} of them ended early, {of['tiles_dry']:,} dry, "
            f"{of['tiles_failed']:,} failed",
        ),
        ("lanes flown", f"{of['lanes_flown_m']:,.0f} of {of['lanes_planned_m']:,.0f} m"),
        ("path flown while pinging", f"{1e-3 * of['path_length_m']:,.1f} km"),
        ("pings", f"{of['pings']:,}"),
        ("simulated", duration_text(of["simulated_s"])),
        (f"at sea, with {of['vehicles']:,} vehicles", duration_text(of["fleet_out_s"])),
        ("collisions", f"{of['collisions']:,}"),
    ]
    if of.get("coverage") is not None:
        rows += [
            ("coverage of the visible surface", f"{100 * of['coverage']:.1f} %"),
            ("of the worst tile", f"{100 * of['coverage_of_the_worst_tile']:.1f} %"),
            ("distance to the true surface, mean", f"{of['distance_mean_m']:.3f} m"),
        ]
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        typer.echo(f"{name:<{width}}  {value}")
    typer.echo(f"{flown.out / 'map.bt'}  {flown.out / 'tiles.png'}  {flown.out / 'summary.json'}")
