"""Options shared by all commands that accept clients: access control and encryption."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.base.options import Options, need, option

TOKEN_VARIABLE, INSTRUCTOR_VARIABLE = "UWSIM_TOKEN", "UWSIM_INSTRUCTOR_TOKEN"
"""Environment variables with tokens, which other users cannot see in the list of processes."""
TOKEN_BYTES_MAX = 1000


@dataclass(frozen=True)
class Tokens(Options):
    """The token with which clients connect."""

    token: str | None = option(
        None,
        "Token that clients must pass: ws://HOST:PORT/?token=TOKEN. All users of this machine can see the options "
        f"of a process: prefer --token-file, or the environment variable {TOKEN_VARIABLE}.",
    )
    token_file: Path | None = option(None, "File with the token, in place of --token.")

    def settings(self, host: str) -> dict[str, Any]:
        """Return the access settings, which all servers of a command share.

        host: the address to listen on. Raises ValueError for two tokens or a bad file.
        """
        return {"host": host, "token": secret("--token", self.token, self.token_file, TOKEN_VARIABLE)}


@dataclass(frozen=True)
class Access(Tokens):
    """The clients that may connect, and encryption. Raises OptionError for a key without a certificate."""

    certfile: Path | None = option(None, "Certificate in PEM, for wss.")
    keyfile: Path | None = option(None, "The certificate's key in PEM.")
    page: tuple[str, ...] = option(
        (),
        "Web page that may connect, in addition to this machine's own, such as https://station.example; file:// for "
        "pages opened from files, and some desktop programs.",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.certfile is None:
            need("--certfile", keyfile=self.keyfile)

    def settings(self, host: str) -> dict[str, Any]:
        """Return the access settings, as for Tokens."""
        return super().settings(host) | {"origins": self.page, "certfile": self.certfile, "keyfile": self.keyfile}


def secret(option: str, value: str | None, file: Path | None, variable: str) -> str | None:
    """Return a token: an option's value, the content of `option`-file or an environment variable. Raises ValueError."""
    if file is None:
        if value is None and (value := os.environ.get(variable)) == "":  # as from a missing file: it would be open
            raise ValueError(f"{variable} is empty: give it a value, or unset it")
        return value
    if value is not None:
        raise ValueError(f"{option}: cannot be given with {option}-file")
    try:
        text = file.read_bytes()[:TOKEN_BYTES_MAX].decode().strip()
    except (OSError, UnicodeDecodeError):
        raise ValueError(f"{option}-file '{file}': must be a readable text file") from None
    if not text:
        raise ValueError(f"{option}-file '{file}': is empty")
    return text
