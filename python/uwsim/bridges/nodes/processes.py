"""Runs the nodes as processes that are forked after all imports. Each is set up before the next one starts."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import threading
from collections.abc import Callable
from multiprocessing.synchronize import Event
from pathlib import Path

from uwsim.bridges.nodes.chain import FLOATS, NODES
from uwsim.bridges.nodes.node import connect_patiently
from uwsim.bridges.rare_log import RareLog

LOOK_S = 0.5


def run_one(name: str, url: str, out: Path, patience_s: float, ready: Callable[[], None], floats: str = FLOATS) -> None:
    """Run a node until the server closes the connection or a signal arrives. Raises OSError if there is no server.

    floats: the type of decodedDepth. Reports from the server, for example about refused messages, are logged.
    """
    node = connect_patiently(url, patience_s)
    node.complain = RareLog(logging.getLogger(f"uwsim.{name}")).warning
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    NODES[name](node, out, floats)
    node.settle()
    ready()
    node.spin(stopping.is_set)
    node.finish()


def run_all(url: str, out: Path, patience_s: float, ready: Callable[[], None], floats: str = FLOATS) -> bool:
    """Run all nodes until one exits or a signal arrives; return whether all succeeded.

    Nodes start from the end of the chain, the string decoder last, so that no ping is lost. Raises OSError.
    """
    connect_patiently(url, patience_s).close()
    context = multiprocessing.get_context("fork")
    processes = []
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.default_int_handler)
        for name in reversed(NODES):
            is_set_up = context.Event()
            process = context.Process(target=_child, args=(name, url, out, patience_s, is_set_up, floats), name=name)
            processes.append(process)
            process.start()
            while not is_set_up.wait(LOOK_S):
                if not process.is_alive():
                    return False
        ready()
        while all(process.is_alive() for process in processes):
            processes[0].join(LOOK_S)
        return not any(process.exitcode for process in processes)
    except KeyboardInterrupt:
        return True
    finally:
        for process in processes:
            process.terminate()
            process.join()


def _child(name: str, url: str, out: Path, patience_s: float, is_set_up: Event, floats: str) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)  # until run_one installs its own
    run_one(name, url, out, patience_s, is_set_up.set, floats)
