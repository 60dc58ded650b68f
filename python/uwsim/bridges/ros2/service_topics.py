"""Topics in place of services, which DDS as we have it cannot carry: a message on a topic calls the service.

A std_srvs/Trigger is called by a std_msgs/Empty on a topic of its name, a std_srvs/SetBool by a std_msgs/Bool; others
by a std_msgs/String that holds the request in JSON. The answer is said on /rosout.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import orjson

from uwsim.bridges.ros2.rosout import INFO, WARN
from uwsim.channels import Channel, Service
from uwsim.live import LiveSimulator

Say = Callable[[int, str], None]
Request = dict[str, Any]
EMPTY, BOOL, STRING = "std_msgs/msg/Empty", "std_msgs/msg/Bool", "std_msgs/msg/String"
MESSAGE_OF = {"std_srvs/srv/Trigger": EMPTY, "std_srvs/srv/SetBool": BOOL}
OPEN_CALLS_MAX = 100

logger = logging.getLogger("uwsim.ros2")


class _Lane:
    """Threads on which calls wait for steps, and room for those that wait for a thread."""

    def __init__(self, threads: int) -> None:
        self.pool = ThreadPoolExecutor(threads, thread_name_prefix="uwsim-ros2-service")
        self.free = threading.Semaphore(OPEN_CALLS_MAX)


class ServiceTopics:
    """The channels that call services, and the threads on which calls wait for steps. say: tells of an answer."""

    def __init__(self, services: Sequence[Service], say: Say) -> None:
        self._say = say
        self._usual, self._vital = _Lane(2), _Lane(1)
        self.channels = [self._channel(service) for service in services]

    def close(self) -> None:
        """Call nothing more."""
        for lane in (self._usual, self._vital):
            lane.pool.shutdown(wait=False, cancel_futures=True)

    def _channel(self, service: Service) -> Channel:
        kind = MESSAGE_OF.get(service.type, STRING)
        lane = self._vital if service.is_vital else self._usual

        def call(live: LiveSimulator, message: Any) -> None:
            request = _request(kind, message)
            if not lane.free.acquire(blocking=False):
                raise ValueError(f"{OPEN_CALLS_MAX} calls wait already: this one is refused")
            lane.pool.submit(service.call, live, request).add_done_callback(
                lambda done: self._answer(lane, service.name, done)
            )

        return Channel(service.name, kind, "in", service.description, apply=call)

    def _answer(self, lane: _Lane, name: str, done: Future[Request]) -> None:
        lane.free.release()
        if done.cancelled():
            return
        error = done.exception()
        if error is not None:
            if not isinstance(error, ValueError | RuntimeError):
                logger.error("service '%s' failed", name, exc_info=error)
            self._say(WARN, f"/{name}: {error}")
            return
        answer = done.result()
        level = INFO if answer.get("success", True) else WARN
        self._say(level, f"/{name}: {orjson.dumps(answer, default=str).decode()}")


def _request(kind: str, message: Any) -> Request:
    """Return the request that a message holds. Raises ValueError."""
    if kind == EMPTY:
        return {}
    if kind == BOOL:
        return {"data": bool(message.data)}
    try:
        request = orjson.loads(message.data or "{}")
    except ValueError as error:
        raise ValueError(f"data = {message.data!r:.60}: must be JSON ({error})") from None
    if not isinstance(request, dict):
        raise ValueError(f"data = {message.data!r:.60}: must be an object in JSON")
    return request
