"""`--toy HOST:PORT`: each reading of some channels as a line of JSON, by UDP."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, option
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.bridges.doctor import Finding
    from uwsim.channels.delivery.feed import Reading


@dataclass(frozen=True)
class ToyOptions(Options):
    """The options of the bridge."""

    switch = "toy"

    toy: str | None = option(None, "Send readings to this address by UDP, as lines of JSON.", metavar="HOST:PORT")
    toy_channel: tuple[str, ...] = option((), "Toy: a channel to send; may be repeated. Default: clock.")
    toy_max: int = option(1400, "Toy: longer lines are not sent [bytes].", bounds=(100, 65000, "bytes"))


class ToyPlug(BridgePlug[ToyOptions]):
    """The bridge. Raises ValueError for a wrong address."""

    options = ToyOptions
    examined = ("toy_max",)

    def __init__(self, options: ToyOptions) -> None:
        super().__init__(options)
        host, _, port = (options.toy or "").rpartition(":")
        if not (host and port.isdecimal()):
            raise ValueError(f"--toy = '{options.toy}': must be HOST:PORT")
        self._address = host, int(port)

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Send until the `with` statement ends. Raises OSError, or ValueError for an unknown channel."""
        import json
        import socket

        from uwsim.channels.ros.messages import to_plain

        known = {channel.name: channel for channel in context.channels if channel.direction == "out"}
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender, ExitStack() as ends:

            def send(reading: Reading) -> None:
                """Send one reading. It is called between two steps, which wait for it."""
                values = {"channel": reading.channel.name, "time_ns": reading.time_ns, **to_plain(reading.message)}
                line = json.dumps(values).encode()
                if len(line) <= self.given.toy_max:
                    sender.sendto(line, self._address)

            for name in self.given.toy_channel or ("clock",):
                if name not in known:
                    raise ValueError(f"--toy-channel = '{name}': must be one of {', '.join(known)}")
                ends.callback(context.feed.listen(known[name], send))
            yield Opened(f"toy at {self.given.toy}")

    @classmethod
    def examine(cls, options: ToyOptions, listen_s: float) -> Iterable[Finding]:
        """Yield a finding of `uwsim ros doctor` about the lines' length."""
        from uwsim.bridges.doctor import Finding

        is_good = options.toy_max <= 1400
        yield Finding("toy", f"lines of {options.toy_max} bytes", "ok" if is_good else "note", "a packet has 1400")
