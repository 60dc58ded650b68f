"""A bridge to the Foxglove app, which can display and control a live simulator: pip install 'uwsim[foxglove]'."""

from uwsim.base.extras import need_extra

need_extra("foxglove", "foxglove", "Foxglove")

from uwsim.bridges.foxglove.server import PORT, FoxgloveServer  # noqa: E402

__all__ = ["PORT", "FoxgloveServer"]
