"""Pictures of 84 x 84 pixels from all members of a batch, compared with Embree alone casting the same rays.

The members are those of the pipeline environment, shortly after their random starts, with the effects of its
observations. Wall time, on one thread and on two. A step is one of the environment, with twenty of the dynamics.
"""

from __future__ import annotations

import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from _harness import Case, Rounds, alternated, console, embree_alone, medians, ratio, show, spent_s

import uwsim.learning  # noqa: F401, registers the environments
from uwsim import Batch
from uwsim.learning.eye import EFFECTS

MEMBERS, SIDE = 256, 84
PACKET = np.dtype([("kind", "<i4"), ("active", "<i4", 16), ("origin", "<f4", (3, 16)), ("others", "<f4", (5, 16))])


def main(rounds: Rounds = 9) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    cases: dict[str, Case] = {}
    with tempfile.TemporaryDirectory() as folder:
        for threads in (1, 2):
            env: Any = gymnasium.make_vec(
                "uwsim/PipelineFollowing-v1", MEMBERS, threads=threads, camera="front"
            ).unwrapped
            env.reset(seed=0)
            actions = np.zeros(env.action_space.shape, np.float32)
            env.step(actions)
            batch = env.episodes.batch
            picture = partial(batch.capture, "front", EFFECTS, size=(SIDE, SIDE))
            cases[f"pictures, {threads} threads"] = partial(spent_s, picture, time.perf_counter)
            cases[f"environment steps, {threads} threads"] = partial(
                spent_s, partial(env.step, actions), time.perf_counter
            )
            eye_m, packets = all_packets(batch)
            if peer := embree_alone(Path(folder) / "rays", batch.world, eye_m, packets.tobytes(), threads, "quads"):
                cases[f"Embree alone, {threads} threads"] = lambda peer=peer: peer.times_s()[0]
        found = alternated(cases, rounds, warm_up=True)
    console.print(f"{MEMBERS} pictures of {SIDE} x {SIDE} pixels: {np.count_nonzero(packets['active']):,} rays")
    results = {f"{name} [1/s]": MEMBERS / wall_s for name, wall_s in medians(found).items()}
    for threads in (1, 2):
        if peer_s := found.get(f"Embree alone, {threads} threads"):
            results[f"pictures, of Embree alone, {threads} threads"] = ratio(
                found[f"pictures, {threads} threads"], peer_s
            )
    show("medians, wall time", results, {"environment steps, 2 threads [1/s]": ">= 4000"})
    return results


def all_packets(batch: Batch) -> tuple[Any, np.ndarray]:
    """Return the first member's eye (3,), and the ray packets of all members' pictures relative to it."""
    packets, first_eye = [], None
    for k in range(batch.n):
        own, eye = batch.aboard(k).rov.cameras["front"].resized(SIDE, SIDE).record_rays(EFFECTS, colours_only=True)
        first_eye = eye if first_eye is None else first_eye
        packets.append(np.frombuffer(own, PACKET).copy())
        packets[-1]["origin"] += (eye - first_eye).astype(np.float32)[:, None]
    return first_eye, np.concatenate(packets)
