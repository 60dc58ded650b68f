"""`uwsim vehicle decompose`: cut a hull into convex pieces for collisions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from uwsim.cli.values import readable, within, writable


def decompose(
    mesh: Annotated[Path, typer.Argument(help="A closed mesh: OBJ, STL, PLY, glTF.", callback=readable)],
    out: Annotated[
        Path | None,
        typer.Option(help="The file to write. Default: MESH.pieces.obj beside the mesh.", callback=writable),
    ] = None,
    threshold: Annotated[
        float,
        typer.Option(
            help="Depth of the hollows that may remain, relative to the mesh's size.", callback=within(0.01, 1)
        ),
    ] = 0.1,
    max_pieces: Annotated[int, typer.Option(help="Maximum number of pieces.", callback=within(1, 256))] = 24,
    up: Annotated[
        Literal["y", "z"] | None,
        typer.Option(
            help="The mesh's axis that points up, as mesh_up in a vehicle's file. Default: y for glTF, else z."
        ),
    ] = None,
) -> None:
    """Decompose a hull into convex pieces for collisions.

    The pieces are for `collision: pieces` in a vehicle's file. Takes ten seconds to minutes; needs CoACD.
    """
    from uwsim.scenario import closed_mesh, load_mesh
    from uwsim.scenario.build.collision_pieces import decompose as decompose_mesh
    from uwsim.scenario.build.collision_pieces import write_pieces

    vertices, triangles = closed_mesh(*load_mesh(mesh, up=up), name=str(mesh))
    pieces = decompose_mesh(vertices, triangles, threshold=threshold, max_pieces=max_pieces)
    target = out or mesh.with_suffix(".pieces.obj")
    write_pieces(pieces, target, made_from=mesh.name)
    typer.echo(f"{target}: {len(pieces)} convex pieces")
