"""A learning task from scratch: hold 3 m off a wall seen only by sonar. docs/guides/own-task.md explains it."""

import numpy as np
from numpy.typing import NDArray

from uwsim.learning.motion import Motion
from uwsim.learning.task import Field, Floats, Start, Task, Verdict

TANK = {
    "name": "tank",
    "terrain": {"source": "noise", "size_m": [40, 40], "spacing_m": 1, "bed_depth_m": 8},
    "obstacles": [{"kind": "box", "name": "wall", "position_m": [10, 0, -4], "size_m": [1, 30, 8]}],
    "vehicles": [
        {"name": "rov", "model": "rov", "start": {"position_m": [0, 0, -4]}, "sonar": {"model": "fan64", "tilt_deg": 0}}
    ],
}
WALL_X_M, OFF_M, DEPTH_M = 9.5, 3.0, 4.0
SECTORS = 16


class StandOff(Task):
    """Hold 3 m off a wall, facing it. The wall is observed only by sonar.

    Start: 2 to 8 m off the wall, heading within 40 degrees of its normal. Reward per step: (1 + cos heading error) / 2
    / (1 + error / 0.5 m) - 0.02 x the mean square of the efforts. Termination: a collision, a distance 8 m too large,
    or a position beyond the wall's ends.
    """

    scenario = TANK
    period_s, duration_s = 0.1, 30.0
    axes = ("surge", "sway", "heave", "yaw")
    draws = 3
    pings = True
    goal_fields = (
        Field("sectors", SECTORS, 20.0, "m", "nearest echo by sector, from starboard", 0.0, usual=(5.0,) * SECTORS),
    )

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin off the wall."""
        x_m = WALL_X_M - 2.0 - 6.0 * draws[:, 0]
        y_m = 12.0 * draws[:, 1] - 6.0
        yaw_rad = np.radians(80.0 * draws[:, 2] - 40.0)
        return Start(np.column_stack([x_m, y_m, np.full(len(x_m), -DEPTH_M)]), yaw_rad)

    def goal(self, now: Motion) -> Floats:
        """Return the nearest echo in each sector of the fan, at most 20 m."""
        ranges_m = np.minimum(self.batch.ping(self.vehicle).ranges_m, 20.0)  # no echo: inf
        return np.array(ranges_m.reshape(len(ranges_m), SECTORS, -1).min(axis=2), np.float64)

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding the right distance and heading."""
        error_m = np.abs(WALL_X_M - now.position_world_m[:, 0] - OFF_M)
        facing = now.heading[:, 0]  # the cosine of the angle to the wall's normal
        reward = 0.5 * (1.0 + facing) / (1.0 + error_m / 0.5) - 0.02 * (actions**2).mean(axis=1)
        lost = (error_m > 8.0) | (np.abs(now.position_world_m[:, 1]) > 14.0)
        turned_deg = np.degrees(np.arccos(np.clip(facing, -1.0, 1.0)))
        figures = {"error_m": error_m, "turned_deg": turned_deg, "success": (error_m < 0.3) & (turned_deg < 10.0)}
        return Verdict(reward, lost | (now.collisions > 0), figures)


def main() -> None:
    """Print the returns of eight vehicles that do nothing, and of eight that act at random."""
    from uwsim.learning.vector_env import BatchEnv  # needed by this program, but not by a task

    env = BatchEnv(StandOff, 8)
    for name, share in (("nothing", 0.0), ("random", 1.0)):
        env.reset(seed=1)
        env.action_space.seed(1)
        earned = np.zeros(8)
        for _ in range(100):
            earned += env.step(share * env.action_space.sample())[1]
        print(f"{name}: {earned.mean():.1f} in 10 s, of at most 100")


if __name__ == "__main__":
    main()
