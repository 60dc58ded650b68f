"""Runs the nodes as processes that are forked after all imports. Each is set up before the next one starts."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from pathlib import Path

from websockets.exceptions import ConnectionClosed, WebSocketException

from uwsim.base.stoppable import ending_signals
from uwsim.bridges.nodes.chain import FLOATS, NODES
from uwsim.bridges.nodes.node import Node, connect_patiently
from uwsim.bridges.nodes.websocket import FIRST_WAIT_S, LONGEST_WAIT_S
from uwsim.bridges.rare_log import RareLog
from uwsim.channels.ros.message_types import Ros

LOOK_S = 0.5


@contextmanager
def _handlers_restored() -> Iterator[None]:
    """Restore the handlers of the signals that end nodes, for callers that go on."""
    before = {number: signal.getsignal(number) for number in ending_signals()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@_handlers_restored()
def run_one(
    name: str,
    url: str,
    out: Path,
    patience_s: float,
    ready: Callable[[], None],
    floats: str = FLOATS,
    ros: Ros | None = None,
) -> None:
    """Run a node until a signal arrives, reconnecting whenever the connection is lost. The map is always written.

    floats: the type of decodedDepth. ros: the server's ROS generation if it does not show it. Reports from the server,
    for example about refused messages, are logged. Raises OSError if there is no server at first, if it refuses
    everything, or if the map cannot be written.
    """
    node = connect_patiently(url, patience_s, ros)
    log = logging.getLogger(f"uwsim.{name}")
    rare = RareLog(log)
    node.complain = lambda text: rare.warning(f"the server reports: {text}")
    stopping = threading.Event()

    def stop(*_: object) -> None:
        stopping.set()
        node.abort()  # so that no send to a slow server delays the end

    for number in ending_signals():
        signal.signal(number, stop)
    parent = multiprocessing.parent_process()

    def is_over() -> bool:
        return stopping.is_set() or (parent is not None and not parent.is_alive())

    try:
        NODES[name](node, out, floats)
        if remark := node.settle():
            log.warning("%s: %s", url, remark)
    except ConnectionClosed:
        if not is_over():
            raise OSError(f"{url}: the connection ended before the node was set up") from None
    try:
        ready()
        _report_refused(node, log, rare)
        while not is_over():
            _spin(node, is_over, rare)
            if not is_over():
                log.warning("%s: the connection has ended; trying to connect again", url)
                _save(node, rare)  # in case it never returns
                _reconnect(node, is_over, stopping.wait)
                if not is_over():
                    log.warning("%s: connected again", url)
    finally:
        node.finish()
    if node.is_refused:
        raise OSError(f"{url}: {'; '.join(node.refusals.summary())}")


def _report_refused(node: Node, log: logging.Logger, rare: RareLog) -> None:
    """Log the topics that the server does not take. A lost connection is left to the loop that reconnects."""
    try:
        node.follow_refusals()
        for topic, kind in node.refused().items():
            log.warning("the server refuses %s: does it lack the package of its type, %s?", topic, kind)
    except ConnectionClosed:
        pass
    except (ValueError, OSError) as error:
        rare.warning(str(error))


def _save(node: Node, rare: RareLog) -> None:
    try:
        node.finish()
    except OSError as error:
        rare.warning(str(error))


def _spin(node: Node, is_over: Callable[[], bool], rare: RareLog) -> None:
    """Run callbacks until the end or until the connection is lost. An invalid message is logged and left out."""
    while not is_over():
        try:
            return node.spin(is_over)
        except ConnectionClosed:
            return None
        except (ValueError, OSError) as error:  # OSError: a map that could not be written meanwhile
            rare.warning(str(error))
    return None


def _reconnect(node: Node, is_over: Callable[[], bool], wait: Callable[[float], object]) -> None:
    """Try to connect until it works or the end, waiting before each attempt, longer after each failure."""
    wait_s = FIRST_WAIT_S
    while not is_over():
        wait(wait_s)
        try:
            return node.reconnect()
        except (OSError, WebSocketException):
            wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)
    return None


@_handlers_restored()
def run_all(
    url: str, out: Path, patience_s: float, ready: Callable[[], None], floats: str = FLOATS, ros: Ros | None = None
) -> bool:
    """Run all nodes until one fails or a signal arrives; return whether all succeeded.

    Nodes start from the end of the chain, the string decoder last, so that no ping is lost. Raises OSError.
    """
    connect_patiently(url, patience_s).close()
    context = multiprocessing.get_context("fork")
    processes = []
    try:
        for number in ending_signals():
            signal.signal(number, signal.default_int_handler)
        for name in reversed(NODES):
            is_set_up = context.Event()
            process = context.Process(
                target=_child, args=(name, url, out, patience_s, is_set_up, floats, ros), name=name
            )
            processes.append(process)
            process.start()
            while not is_set_up.wait(LOOK_S):
                if not process.is_alive():
                    return False
        ready()
        while all(process.is_alive() for process in processes):
            processes[0].join(LOOK_S)
    except KeyboardInterrupt:
        pass
    finally:
        for number in ending_signals():
            signal.signal(number, signal.SIG_IGN)  # until the nodes have written what they have
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()
    return not any(process.exitcode for process in processes)


def _child(name: str, url: str, out: Path, patience_s: float, is_set_up: Event, floats: str, ros: Ros | None) -> None:
    for number in ending_signals():
        signal.signal(number, signal.SIG_DFL)  # until run_one installs its own
    try:
        run_one(name, url, out, patience_s, is_set_up.set, floats, ros)
    except (OSError, ValueError) as error:
        logging.getLogger(f"uwsim.{name}").error("%s", error)
        sys.exit(1)
