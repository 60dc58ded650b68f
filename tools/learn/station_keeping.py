"""Train uwsim/StationKeeping-v0 by CMA-ES, compare the result with the PID of the vehicle's file, and plot both.

    python tools/learn/station_keeping.py --out assets/learning/policies/station_keeping.json \
        --curve docs/guides/learning.png

The search starts from proportional control with damping, with one gain for all axes of a kind (`first_guess`), and is
unconstrained from there. Training episodes have the seeds 0, 1, ...; those for the comparison begin at 1,000,000.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from uwsim.learning.episodes import Episodes
from uwsim.learning.evolve import Generation, evolve
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.pid import Pid
from uwsim.learning.policy import LinearPolicy
from uwsim.learning.returns import Flown, fly
from uwsim.learning.tasks import StationKeeping

HELD_OUT = 1_000_000
SETTLED_S = 10.0


def main(
    out: Annotated[Path, typer.Option(help="The file for the policy.")] = Path("station_keeping.json"),
    curve: Annotated[Path, typer.Option(help="The file for the picture.")] = Path("station_keeping.png"),
    generations: Annotated[int, typer.Option(min=1)] = 150,
    candidates: Annotated[int, typer.Option(min=4)] = 16,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes of each candidate in a generation.")] = 6,
    compared: Annotated[int, typer.Option(min=1, help="Episodes for the comparison.")] = 64,
    threads: Annotated[int | None, typer.Option(min=1)] = None,
) -> None:
    """Train, compare and plot."""
    options = EpisodeOptions(threads=threads, normalise=False)
    course: list[Generation] = []

    def told(generation: Generation) -> None:
        course.append(generation)
        if generation.index % 10 == 0:
            mean, best, cpu_s = generation.mean, generation.best, generation.processor_s
            print(f"generation {generation.index}: {mean:.1f}, best {best:.1f}, {cpu_s:.0f} s", flush=True)

    policy = evolve(
        StationKeeping, options, generations=generations, candidates=candidates, episodes_each=episodes,
        start=first_guess(), spread=0.1, notify=told,
    )  # fmt: skip
    arena = Episodes(StationKeeping, compared, options)
    seeds = range(HELD_OUT, HELD_OUT + compared)
    pid = fly(arena, Pid(arena, StationKeeping.place_m), seeds)
    learned = fly(arena, policy, seeds)
    about = {
        "environment": "uwsim/StationKeeping-v0",
        "found_by": f"CMA-ES, {generations} generations of {candidates} candidates, {episodes} episodes each, seed 0",
        "processor_s": round(course[-1].processor_s),
        "held_out_seeds": [HELD_OUT, HELD_OUT + compared - 1],
        "return": round(float(learned.total.mean()), 1),
        "return_of_pid": round(float(pid.total.mean()), 1),
    }
    out.parent.mkdir(parents=True, exist_ok=True)
    LinearPolicy(policy.weights, policy.bias, about).save(out)
    for name, flown in (("PID", pid), ("learned", learned)):
        print(
            f"{name}: return {flown.total.mean():.1f} +- {flown.total.std():.1f}, least {flown.total.min():.1f}; "
            f"after {SETTLED_S:g} s {settled_m(flown):.3f} m rms"
        )
    print(f"better than the PID in {(learned.total > pid.total).sum()} of {compared} episodes")
    draw(course, pid, learned, curve)


def first_guess() -> LinearPolicy:
    """Return proportional control towards the target position and heading and level attitude, with damping."""
    weights = np.zeros((6, 21))
    for axis in range(3):
        weights[axis, axis], weights[axis, 9 + axis] = 3.0, -2.0  # the direction to the place; the velocity
        weights[3 + axis, 12 + axis] = -0.3  # the rate
    weights[3, 7], weights[4, 6], weights[5, 4] = -1.0, 1.0, 1.0  # up to port, up ahead, the heading to port
    return LinearPolicy(weights, np.zeros(6))


def settled_m(flown: Flown) -> float:
    """Return the rms distance from the target over the second half of the episodes."""
    later = flown.figures["distance_m"][round(SETTLED_S / StationKeeping.period_s) :]
    return float(np.sqrt(np.nanmean(later**2)))


def draw(course: list[Generation], pid: Flown, learned: Flown, path: Path) -> None:
    """Plot the progress of training, and the distance of both controllers over time."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    cpu_s = [generation.processor_s for generation in course]
    left.plot(cpu_s, [generation.best for generation in course], lw=1, alpha=0.6, label="best candidate")
    left.plot(cpu_s, [generation.mean for generation in course], lw=1.5, label="mean of the generation")
    left.axhline(pid.total.mean(), ls="--", color="k", lw=1, label="PID, held-out seeds")
    left.axhline(learned.total.mean(), ls=":", color="C3", lw=1.5, label="learned, held-out seeds")
    left.set(xlabel="processor time [s]", ylabel="return of an episode of 20 s", title="CMA-ES, 66 weights")
    left.legend(loc="lower right", fontsize=8)
    for flown, label, colour in ((pid, "PID of the vehicle's file", "k"), (learned, "learned", "C3")):
        band(right, flown.figures["distance_m"], label, colour)
    right.set(xlabel="time [s]", ylabel="distance [m]", yscale="log", title="in gusts, median and 10 to 90 %")
    right.legend(fontsize=8)
    for panel in (left, right):
        panel.grid(alpha=0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def band(panel: object, distance_m: NDArray[np.float64], label: str, colour: str) -> None:
    """Plot the median and the 10th to 90th percentile over the episodes."""
    time_s = StationKeeping.period_s * np.arange(1, len(distance_m) + 1)
    low, middle, high = np.nanpercentile(distance_m, [10, 50, 90], axis=1)
    panel.fill_between(time_s, low, high, alpha=0.2, color=colour)  # type: ignore[attr-defined]
    panel.plot(time_s, middle, label=label, color=colour, lw=1.5)  # type: ignore[attr-defined]


if __name__ == "__main__":
    typer.run(main)
