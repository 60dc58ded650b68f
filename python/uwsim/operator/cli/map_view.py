"""`uwsim map view`: a map in 3D, in the browser."""

from __future__ import annotations

from typing import Annotated

import typer

from uwsim.cli.map import MapFile
from uwsim.cli.values import within


def view(
    source: MapFile,
    port: Annotated[int, typer.Option(help="Port to listen on; 0 chooses a free one.", callback=within(0, 65535))] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Whether to open the page.")] = True,
) -> None:
    """Show a map in 3D in the browser, until Ctrl-C.

    Occupied voxels are coloured by height. The page needs no internet access; other machines cannot connect.
    """
    from uwsim.cli.run_live import wait_for_interrupt
    from uwsim.mapping.files.map_files import open_map
    from uwsim.operator.framed import has_display
    from uwsim.operator.map_view import MapViewer

    with MapViewer(open_map(source), source.name, port=port).open(browser and has_display()) as viewer:
        wait_for_interrupt(f"the map is at {viewer.url}; Ctrl-C ends it")
