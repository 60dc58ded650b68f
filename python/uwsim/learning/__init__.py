"""Gymnasium environments for learning: `pip install 'uwsim[learning]'`, then `import uwsim.learning` registers them.

    import gymnasium
    import uwsim.learning

    env = gymnasium.make("uwsim/StationKeeping-v1")
    envs = gymnasium.make_vec("uwsim/StationKeeping-v1", num_envs=256)  # on uwsim.Batch
    uwsim.learning.register("lab/Hover-v0", Hover)  # a task of your own

docs/guides/learning.md lists the environments, their spaces, units and rewards; docs/guides/own-task.md starts from an
empty file.
"""

from uwsim.base.extras import need_extra

need_extra("gymnasium", "uwsim.learning")

from uwsim.learning.registration import ENVIRONMENTS, register, register_packaged  # noqa: E402, after the check

register_packaged()

__all__ = ["ENVIRONMENTS", "register"]
