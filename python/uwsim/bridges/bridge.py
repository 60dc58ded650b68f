"""Bridge: the base class for connecting a live simulator or a recording to peers outside this process."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from types import TracebackType
from typing import Any, Self

from uwsim.bridges.answers import Answer, Lane, outcome
from uwsim.channels import Channel, Service, require_live, start_updates
from uwsim.channels.delivery.feed import Feed, Reading, Readings
from uwsim.live import LiveSimulator, NotRunningError, Subscription

COMMAND_BYTES_MAX = 1 << 20
SERVICE_THREADS = 4


class Bridge:
    """The simulator's side of a bridge: channels and services by name, a feed for readings, and threads for calls.

    A channel is read only while a peer subscribes to it. `take` receives the readings on the simulator's thread, which
    it must not block. Commands and calls may come from any thread, and take effect between two steps.

    name: used to name the logger, uwsim.NAME, and the threads. live: None if the feed plays a recording, which accepts
    no commands. feed: shared with other sinks so that each reading is taken only once; defaults to a new one.
    open_calls: maximum number of unanswered calls; None if the subclass limits them.
    """

    peer = "a client"
    """The kind of peer, as shown to a station's pilots."""

    def __init__(
        self,
        name: str,
        live: LiveSimulator | None,
        channels: Iterable[Channel],
        services: Iterable[Service] = (),
        feed: Readings | None = None,
        *,
        open_calls: int | None = None,
    ) -> None:
        channels = list(channels)
        self.log = logging.getLogger(f"uwsim.{name}")
        self.live = live
        self.feed = feed or Feed(require_live(live))
        self.outputs = {channel.name: channel for channel in channels if channel.direction == "out"}
        self.inputs = {channel.name: channel for channel in channels if channel.direction == "in"}
        self.services = {service.name: service for service in services}
        self.is_closed = False
        self._usual = Lane(f"uwsim-{name}-service", SERVICE_THREADS, self.log, open_calls)
        self._vital = Lane(f"uwsim-{name}-vital", 1, self.log)
        self._lock = threading.Lock()
        self._ends: dict[str, Callable[[], None]] = {}  # functions that stop reading, by channel
        self._updates: list[Subscription] = []

    def start_updates(self) -> None:
        """Start the work that channels do even when they are not being read. Subclass constructors call this last."""
        self._updates = start_updates(self.live, self.outputs.values())

    def close(self) -> bool:
        """Stop readings, commands and calls; return whether this was the first call to `close`."""
        with self._lock:
            was_open, self.is_closed = not self.is_closed, True
            ends = list(self._ends.values())
            self._ends.clear()
        for end in (*ends, *(subscription.cancel for subscription in self._updates)):
            end()
        self._usual.close()
        self._vital.close()
        return was_open

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    # From the simulator

    def take(self, reading: Reading) -> None:
        """Handle a reading of a channel that is being read. Must not block."""
        raise NotImplementedError

    def listen(self, name: str) -> None:
        """Start reading a channel. Raises NotRunningError."""
        with self._lock:
            if name not in self._ends and not self.is_closed:
                self._ends[name] = self.feed.listen(self.outputs[name], self.take)

    def leave(self, name: str) -> None:
        """Stop reading a channel."""
        with self._lock:
            end = self._ends.pop(name, None)
        if end is not None:
            end()

    def is_read(self, name: str) -> bool:
        """Return whether a channel is being read."""
        return name in self._ends

    def demand(self, name: str, is_wanted: bool) -> None:
        """Start or stop reading a channel. Failures are logged."""
        if not is_wanted:
            self.leave(name)
            return
        try:
            self.listen(name)
        except NotRunningError:
            self.log.warning("topic '%s': the simulator does not run", name)

    # To the simulator

    def apply(self, channel: Channel, message: Any) -> None:
        """Apply a command. Raises ValueError or RuntimeError."""
        live = require_live(self.live)
        if channel.authority.door is None:
            channel.apply(live, message)
        else:
            channel.authority.door.apply(live, channel, message, self.peer)

    def receive(self, channel: Channel, data: bytes, decode: Callable[[bytes, str], Any]) -> None:
        """Decode a command and apply it, or call `refuse` with the error."""
        try:
            if len(data) > COMMAND_BYTES_MAX:
                raise ValueError(f"{len(data)} bytes: must be {COMMAND_BYTES_MAX} at most")
            self.apply(channel, decode(data, channel.type))
        except (ValueError, RuntimeError) as error:
            self.refuse(f"/{channel.name}: {error}")
        except Exception:
            self.log.exception("topic '%s': a message could not be applied", channel.name)

    def refuse(self, reason: str) -> None:
        """Report a rejected command."""
        self.log.warning("%s", reason)

    def abandon(self, channel: Channel) -> None:
        """Notify a channel that the last peer to send commands on it has gone."""
        if channel.authority.door is None or self.live is None:
            return
        try:
            channel.authority.door.left(self.live, channel)
        except (ValueError, RuntimeError) as error:
            self.log.warning("topic '%s': %s", channel.name, error)

    def call(self, service: Service, request: dict[str, Any], answer: Answer) -> None:
        """Call a service on a separate thread, because it may block waiting for steps, and answer from that thread.

        Vital services are called at once, so that no other call delays them and they keep their order. Raises
        ValueError or RuntimeError.
        """
        require_live(self.live)
        if not service.is_vital:
            self._usual.submit(partial(self.respond, service, request), answer)
            return
        succeeded, found = outcome(lambda: self._begin(service, request), self.log)
        if not isinstance(found, Future):
            answer(succeeded, found)
            return

        def finish(done: Future[Any]) -> None:  # on the simulator's thread, which an answer could block
            with suppress(RuntimeError):  # closed
                self._vital.submit(done.result, answer)

        found.add_done_callback(finish)

    def respond(self, service: Service, request: dict[str, Any]) -> dict[str, Any]:
        """Call a service on this thread and return the response, which is a refusal if the caller lacks the right."""
        found = self._begin(service, request)
        return found.result() if isinstance(found, Future) else found

    def _begin(self, service: Service, request: dict[str, Any]) -> dict[str, Any] | Future[dict[str, Any]]:
        live = require_live(self.live)
        try:
            if service.permit is not None:
                service.permit(service.name, request)
        except ValueError as error:
            return {"success": False, "message": str(error)}
        return service.call(live, request)
