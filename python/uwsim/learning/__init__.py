"""Gymnasium environments for learning: `pip install 'uwsim[gym]'`, then `import uwsim.learning` registers them.

    import gymnasium
    import uwsim.learning

    env = gymnasium.make("uwsim/StationKeeping-v0")
    envs = gymnasium.make_vec("uwsim/StationKeeping-v0", num_envs=256)  # on uwsim.Batch

docs/guides/learning.md lists the environments, their spaces, units and rewards.
"""

from uwsim.base.extras import need_extra

need_extra("gymnasium", "gym", "uwsim.learning")

from uwsim.learning.registration import ENVIRONMENTS, register  # noqa: E402, after the check

register()

__all__ = ["ENVIRONMENTS"]
