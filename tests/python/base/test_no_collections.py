"""Garbage collection is paused during the block, and afterwards works as before."""

import gc
import weakref
from collections.abc import Iterator

import pytest

from uwsim.base.no_collections import no_collections


class Node:
    """An object that refers to itself, so that only a collection removes it."""

    def __init__(self) -> None:
        self.itself = self


@pytest.fixture(autouse=True)
def enabled() -> Iterator[None]:
    """Let the collector begin without frozen objects and, for speed, with few that it would visit."""
    were_frozen = gc.get_freeze_count() > 0
    gc.enable()
    gc.unfreeze()
    yield
    gc.enable()
    gc.unfreeze()
    if were_frozen:
        gc.freeze()


def test_no_collection_in_the_block_and_none_due_after_it_but_its_garbage_is_collected() -> None:
    begun: list[int] = []

    def note(phase: str, info: dict[str, int]) -> None:
        if phase == "start":
            begun.append(info["generation"])

    gc.callbacks.append(note)
    try:
        with no_collections():
            kept = [[] for _ in range(5 * gc.get_threshold()[0])]
            known = weakref.ref(Node())
        found = len(begun)
        del kept
    finally:
        gc.callbacks.remove(note)
    assert found == 0 and gc.isenabled()
    gc.collect()
    assert known() is None


def test_a_collector_that_was_off_stays_off_and_objects_that_the_caller_froze_stay_frozen() -> None:
    gc.freeze()
    frozen = gc.get_freeze_count()
    with no_collections():
        pass
    assert gc.get_freeze_count() == frozen > 0
    gc.disable()
    with no_collections():
        pass
    assert not gc.isenabled()
