"""A ROS 2 node's connection over Zenoh, compatible with rmw_zenoh_cpp.

For keys, tokens and attachments, see `zenoh_names`.

Sessions find each other through a router (`ros2 run rmw_zenoh_cpp rmw_zenohd`), and then connect directly.
"""

from __future__ import annotations

import itertools
import os
import threading
import time
import warnings
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

import zenoh
import zenoh.ext

from uwsim.bridges.doors.places import HALF_OPEN_S
from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.ros2.settings import ZENOH_PORT, Ros2Settings
from uwsim.bridges.ros2.transport import DEPTH, Call
from uwsim.bridges.ros2.zenoh_names import ATTACHMENT, Entity, attachment, gid_of

ROUTER_S, LOOK_S = 1.0, 0.02
CALLS_MAX = 100
CLIENT_MS = 10_000  # how long to wait for a router on another machine
PENDING_MAX = 10_000  # half-open connections, as rmw_zenoh has it; Zenoh's own value, 100, silent ones would take up
CONFIG_FILE, CONFIG_CHANGES = "ZENOH_SESSION_CONFIG_URI", "ZENOH_CONFIG_OVERRIDE"
"""The environment variables that configure rmw_zenoh."""


class ZenohTransport:
    """A `Transport`. node: the node's name. Raises OSError if a session cannot be opened; warns without a router."""

    def __init__(self, settings: Ros2Settings, node: str) -> None:
        self._settings, self._node = settings, node
        try:
            self._session: Any = zenoh.open(config_of(settings))
        except zenoh.ZError as error:
            raise OSError(f"cannot open a Zenoh session: {str(error).partition(' at /')[0]}") from None
        self._id = str(self._session.zid())
        self._numbers = itertools.count(1)
        self._events = ZenohEvents()
        self._watched: dict[str, ZenohWriter | ZenohReader] = {}
        self._lock = threading.Lock()
        self._others: dict[str, Counter[str]] = {"MP": Counter(), "MS": Counter()}
        self._tokens: list[Any] = []
        self._require_router()
        self._liveliness = self._session.liveliness().declare_subscriber(
            f"@ros2_lv/{settings.domain_id}/**", self._notice, history=True
        )

    def writer(self, topic: str, type_name: str, depth: int, *, latched: bool) -> ZenohWriter:
        """Return a new writer."""
        entity = self._entity("MP", topic, type_name, depth, latched=latched)
        if latched:
            publisher = zenoh.ext.declare_advanced_publisher(
                self._session, entity.key, cache=zenoh.ext.CacheConfig(max_samples=depth), publisher_detection=True
            )
        else:
            publisher = self._session.declare_publisher(entity.key)
        writer = ZenohWriter(publisher, gid_of(entity.token), partial(self._count, "MS", entity.key))
        self._watch("MS", entity, writer)
        return writer

    def reader(self, topic: str, type_name: str, *, reliable: bool) -> ZenohReader:
        """Return a new reader."""
        entity = self._entity("MS", topic, type_name, DEPTH, reliable=reliable)
        reader = ZenohReader(self._events, partial(self._count, "MP", entity.key))
        reader.subscriber = self._session.declare_subscriber(entity.key, reader.receive)
        self._watch("MP", entity, reader)
        return reader

    def server(self, name: str, type_name: str) -> ZenohServer:
        """Return a new server of a service."""
        entity = self._entity("SS", name, type_name, DEPTH)
        server = ZenohServer(entity.key, self._events)
        server.queryable = self._session.declare_queryable(entity.key, server.receive, complete=True)
        self._announce(entity)
        return server

    def wait_set(self) -> ZenohEvents:
        """Return an object that waits for events from all readers, writers and servers."""
        return self._events

    def announce(self) -> None:
        """Announce the node; its endpoints have been announced already."""
        self._announce(Entity("NN", self._settings, self._id, 0, self._node))

    def close(self) -> None:
        """Close the session; other nodes are notified."""
        self._session.close()

    def _entity(self, kind: str, name: str, type_name: str, depth: int, **qos: bool) -> Entity:
        number = next(self._numbers)
        return Entity(kind, self._settings, self._id, number, self._node, name, type_name, depth, **qos)

    def _announce(self, entity: Entity) -> None:
        self._tokens.append(self._session.liveliness().declare_token(entity.token))

    def _watch(self, kind: str, entity: Entity, source: ZenohWriter | ZenohReader) -> None:
        with self._lock:
            self._watched[kind + entity.key] = source
            is_matched = self._others[kind][entity.key] > 0
        if is_matched:
            self._events.put(source)
        self._announce(entity)

    def _count(self, kind: str, key: str) -> int:
        return self._others[kind][key]

    def _notice(self, sample: Any) -> None:
        """Count publishers and subscriptions of other sessions as they come and go, on a Zenoh thread."""
        parts = str(sample.key_expr).split("/")
        if len(parts) != 13 or parts[2] == self._id or parts[5] not in self._others:
            return
        kind, key = parts[5], "/".join((parts[1], parts[9].replace("%", "/").strip("/"), parts[10], parts[11]))
        with self._lock:
            self._others[kind][key] += 1 if sample.kind == zenoh.SampleKind.PUT else -1
            source = self._watched.get(kind + key)
        if source is not None:
            self._events.put(source)

    def _require_router(self) -> None:
        deadline = time.monotonic() + ROUTER_S
        while not self._session.info.routers_zid():
            if time.monotonic() > deadline:
                advice = "start one (ros2 run rmw_zenoh_cpp rmw_zenohd), and it will be used"
                warnings.warn(f"ROS 2: no Zenoh router answers: {advice}", stacklevel=2)
                return
            time.sleep(LOOK_S)


class ZenohEvents:
    """A queue of sources that have new messages or calls, or whose matching endpoints have changed."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[Any] = SimpleQueue()

    def attach(self, source: object) -> None:
        """Do nothing, because all sources report their events from the start."""

    def put(self, source: object) -> None:
        """Report an event, from any thread."""
        self._queue.put(source)

    def wake(self) -> None:
        """End a wait, from any thread."""
        self._queue.put(None)

    def wait(self, timeout_s: float) -> Sequence[Any]:
        """Wait for events; return their sources, or none after a timeout or `wake`."""
        found = {}
        with suppress(Empty):
            found[self._queue.get(timeout=timeout_s)] = True
            while True:
                found[self._queue.get_nowait()] = True
        return [source for source in found if source is not None]


class ZenohWriter:
    """Writes CDR to one topic."""

    def __init__(self, publisher: Any, gid: bytes, readers: Any) -> None:
        self._publisher, self._gid, self._sequence = publisher, gid, itertools.count(1)
        self.readers = readers

    def write(self, cdr: memoryview) -> bool:
        """Write a message; return whether it was accepted."""
        try:
            self._publisher.put(bytes(cdr), attachment=attachment(next(self._sequence), time.time_ns(), self._gid))
        except zenoh.ZError:
            return False
        return True

    def has_best_effort_readers(self) -> bool:
        """Return False: Zenoh sends over TCP, which loses nothing."""
        return False


class ZenohReader:
    """Reads CDR from one topic."""

    def __init__(self, events: ZenohEvents, writers: Any) -> None:
        self._events, self.writers = events, writers
        self._found = Waiting[bytes](DEPTH)
        self.subscriber: Any = None

    def receive(self, sample: Any) -> None:
        """Queue a message, on a Zenoh thread."""
        self._found.put(sample.payload.to_bytes())
        self._events.put(self)

    def take(self, limit: int) -> list[bytes]:
        """Return up to `limit` messages that have arrived."""
        return self._found.taken(limit)


class ZenohServer:
    """A `Server`. key: the service's key, for requests and responses."""

    def __init__(self, key: str, events: ZenohEvents) -> None:
        self._key, self._events = key, events
        self._found = Waiting[Any](CALLS_MAX)
        self.queryable: Any = None

    def receive(self, query: Any) -> None:
        """Queue a call, on a Zenoh thread."""
        self._found.put(query)
        self._events.put(self)

    def take(self, limit: int) -> list[Call]:
        """Return up to `limit` calls that have arrived. Queries without an attachment are ignored."""
        calls = []
        for query in self._found.taken(limit):
            asked = b"" if query.attachment is None else query.attachment.to_bytes()
            if query.payload is not None and len(asked) == ATTACHMENT.size:
                calls.append(Call(query.payload.to_bytes(), partial(self._reply, query, asked)))
            else:
                query.drop()
        return calls

    def _reply(self, query: Any, asked: bytes, response: memoryview) -> bool:
        sequence, _, _, gid = ATTACHMENT.unpack(asked)
        query.reply(self._key, bytes(response), attachment=attachment(sequence, time.time_ns(), gid))
        query.drop()
        return True


def config_of(settings: Ros2Settings) -> Any:
    """Return the session's configuration: rmw_zenoh's defaults, unless its environment variables change them."""
    file = os.environ.get(CONFIG_FILE)
    config: Any = zenoh.Config.from_file(file) if file else zenoh.Config()
    if not file:
        is_far = settings.reach == "subnet" and bool(settings.peers)
        hosts = settings.peers if is_far else ("localhost",)
        endpoints = ", ".join(f'"tcp/{host}"' if ":" in host else f'"tcp/{host}:{ZENOH_PORT}"' for host in hosts)
        for key, value in {
            # Sessions on another machine accept only local connections, so messages must go through its router.
            "mode": '"client"' if is_far else '"peer"',
            "connect/timeout_ms": str(CLIENT_MS) if is_far else "-1",
            "connect/endpoints": f"[{endpoints}]",
            "listen/endpoints": '["tcp/localhost:0"]',
            "scouting/multicast/enabled": "false",
            "timestamping/enabled": "true",
            # Zenoh accepts no further connection while so many are half open, and gives each so long.
            "transport/unicast/accept_pending": str(PENDING_MAX),
            "transport/unicast/accept_timeout": f"{1000 * HALF_OPEN_S:.0f}",
        }.items():
            config.insert_json5(key, value)
    for change in filter(None, os.environ.get(CONFIG_CHANGES, "").split(";")):
        key, _, value = change.partition("=")
        config.insert_json5(key.strip(), value.strip())
    return config
