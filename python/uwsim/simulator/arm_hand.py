"""The end of an arm: the jaws of its gripper, and the link that carries them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

NUDGE = 1e-3  # rad or m, by which a joint is moved to see what it does

Links = Sequence[_core.ArmLink]


def jaws(links: Links) -> dict[str, float]:
    """Return the joints of an arm's gripper: links with motors side by side on one link, which hold nothing themselves.

    The sign of each is that of the speed that brings its centre of mass nearer to the others'. The first such links
    count; {} if there are none.
    """
    holders = {link.parent for link in links}
    ends = [k for k, link in enumerate(links) if k not in holders and link.strongest > 0.0]
    for first in ends:
        beside = [k for k in ends if links[k].parent == links[first].parent]
        if len(beside) > 1:
            return {links[k].name: _closing(links, k, [other for other in beside if other != k]) for k in beside}
    return {}


def hand(links: Links, jaws: Mapping[str, float]) -> str:
    """Return the name of the link that holds the jaws, or of the last one; "" if the vehicle holds the jaws."""
    if not jaws:
        return links[-1].name
    parent = next(link.parent for link in links if link.name in jaws)
    return "" if parent is None else links[parent].name


def motors_to(links: Links, name: str) -> list[str]:
    """Return the joints with motors from a link to the vehicle."""
    found = []
    at = next((k for k, link in enumerate(links) if link.name == name), None)
    while at is not None:
        if links[at].strongest > 0.0:
            found.append(links[at].name)
        at = links[at].parent
    return found


def _closing(links: Links, own: int, others: Sequence[int]) -> float:
    """Return the sign of a joint's speed that brings its link nearer to others, from where all are at first."""
    still, water = _core.Mechanism(list(links)), _core.Water()

    def middle(k: int) -> NDArray[np.float64]:
        pose = still.world_from_link(k, water)
        return np.asarray(pose[:3, :3] @ links[k].centre_of_mass_m + pose[:3, 3])

    def distance_m() -> float:
        return float(np.linalg.norm(np.mean([middle(k) for k in others], axis=0) - middle(own)))

    for k, link in enumerate(links):
        if link.joint != _core.JointKind.FIXED:
            still.place(k, link.start)
    before_m = distance_m()
    still.place(own, links[own].start + NUDGE)
    return 1.0 if distance_m() <= before_m else -1.0
