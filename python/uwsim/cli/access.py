"""Options shared by all commands that accept clients: access control and encryption."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from uwsim.cli.bounds import readable
from uwsim.cli.options import need

Token = Annotated[str | None, typer.Option(help="Token that clients must pass: ws://HOST:PORT/?token=TOKEN.")]
Certfile = Annotated[Path | None, typer.Option(help="Certificate in PEM, for wss.", callback=readable)]
Keyfile = Annotated[Path | None, typer.Option(help="The certificate's key in PEM.", callback=readable)]
Page = Annotated[
    list[str] | None,
    typer.Option(
        help="Web page that may connect, in addition to this machine's own, such as https://station.example; "
        "file:// for pages opened from files, and some desktop programs."
    ),
]


def access(
    host: str, *, page: Sequence[str] | None, token: str | None, certfile: Path | None, keyfile: Path | None
) -> dict[str, Any]:
    """Return the access settings, which all servers of a command share.

    Raises WithoutEffectError for a keyfile without a certfile.
    """
    if certfile is None:
        need("--certfile", keyfile=keyfile)
    return {"host": host, "origins": page or (), "token": token, "certfile": certfile, "keyfile": keyfile}
