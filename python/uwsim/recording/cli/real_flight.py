"""Options of commands that read the log of a real flight."""

from __future__ import annotations

from typing import Annotated

import typer

LogColumns = Annotated[
    str | None,
    typer.Option(
        "--columns",
        help="Of a table: what each column is, such as 't = time [s], yaw = heading [deg], m1 = servo1 [us]', or a "
        "YAML file with such lines.",
    ),
]
LogOutputs = Annotated[
    str | None,
    typer.Option(
        "--outputs",
        help="Which output drives which thruster: vectored, vectored_6dof, order (as in the vehicle's file) or pairs "
        "such as 1=front_right,2=-front_left. Default: the frame that the log states.",
    ),
]
