"""Options shared by all commands that accept clients: access control and encryption."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.base.options import Options, need, option

TOKEN_VARIABLE = "UWSIM_TOKEN"
"""Environment variable with the token, which other users cannot see in the list of processes."""
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
        return {"host": host, "token": _secret(self.token, self.token_file)}


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


def _secret(value: str | None, file: Path | None) -> str | None:
    """Return the token: the option's value, the file's content or the environment variable's. Raises ValueError."""
    if file is None:
        if value is None and (value := os.environ.get(TOKEN_VARIABLE)) == "":  # as from a missing file: it is no token
            raise ValueError(f"{TOKEN_VARIABLE} is empty: give it a value, or unset it")
        return value
    if value is not None:
        raise ValueError("--token: cannot be given with --token-file")
    try:
        text = file.read_bytes()[:TOKEN_BYTES_MAX].decode().strip()
    except (OSError, UnicodeDecodeError):
        raise ValueError(f"--token-file '{file}': must be a readable text file") from None
    if not text:
        raise ValueError(f"--token-file '{file}': is empty")
    return text
