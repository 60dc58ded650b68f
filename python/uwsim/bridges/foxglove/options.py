"""The options of `--foxglove`, apart from the server, so that `--help` is fast."""

from __future__ import annotations

from dataclasses import dataclass

from uwsim.base.options import Options, option

PORT = 8765
"""The app's default."""


@dataclass(frozen=True)
class FoxgloveOptions(Options):
    """The options of the Foxglove server."""

    switch = "foxglove"

    foxglove: bool = option(False, "Also serve the Foxglove app; see docs/connections/foxglove.md.")
    foxglove_port: int | None = option(None, f"Port for Foxglove. Default: {PORT}.", bounds=(0, 65535, ""))

    @property
    def port(self) -> int:
        """The port, where 0 is a free one."""
        return PORT if self.foxglove_port is None else self.foxglove_port
