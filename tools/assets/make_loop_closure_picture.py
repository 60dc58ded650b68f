"""Draw docs/guides/loop-closure.png: the drift of a survey without USBL, before and after closing its loops."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from uwsim import Simulator
from uwsim.flight.closed_flight import PingKeeper
from uwsim.flight.survey import fly_survey
from uwsim.mapping.closure import ClosedTrack, close_loops

PICTURE = Path(__file__).parents[2] / "docs" / "guides" / "loop-closure.png"
Array = NDArray[np.float64]


def draw(true_m: Array, drifted_m: Array, closed_m: Array, links_m: Array, path: Path) -> None:
    """Draw tracks (n, 3) and the matches (k, 2, 2) between submaps."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    left.plot(*closed_m[:, :2].T, lw=0.8, label="closed track")
    for link in links_m:
        left.plot(*link.T, color="tab:green", lw=0.5)
    left.set(xlabel="east [m]", ylabel="north [m]", title=f"{len(links_m)} matches of submaps", aspect="equal")
    for name, track in (("estimated", drifted_m), ("closed", closed_m)):
        error = np.linalg.norm((track - true_m)[:, :2], axis=1)
        right.plot(error, lw=0.8, label=f"{name}: mean {error.mean():.2f} m, at most {error.max():.2f} m")
    right.set(xlabel="ping", ylabel="horizontal error [m]", title="Without USBL", ylim=(0.0, None))
    right.legend()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def links(closed: ClosedTrack) -> Array:
    """Return the anchors of the submaps that were matched, (k, 2, 2)."""
    return np.array([[closed.submaps[m.first].anchor_m, closed.submaps[m.second].anchor_m] for m in closed.matches])


def main() -> None:
    """Fly the lake's survey with its USBL switched off, and close its loops."""
    sim = Simulator("lake", seed=7)
    sim.parameters["rov.sensors.usbl.on"] = False
    keeper, true_m = PingKeeper(sim), []

    def take(ping, panel, body) -> None:  # type: ignore[no-untyped-def]
        keeper(ping, panel, body)
        true_m.append(sim.rov.pose.position_world_m)

    fly_survey(sim, estimate="filter", on_ping_taken=take)
    closed = close_loops(keeper.track)
    drifted_m, closed_m = (np.array(t)[:, :3, 3] for t in (keeper.track.world_from_body, closed.world_from_body))
    draw(np.array(true_m), drifted_m, closed_m, links(closed), PICTURE)


if __name__ == "__main__":
    main()
