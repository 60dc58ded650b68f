"""A bridge to the Foxglove app, which can display and control a live simulator: pip install 'uwsim[foxglove]'."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.foxglove.options import PORT
    from uwsim.bridges.foxglove.server import FoxgloveServer

__all__ = ["PORT", "FoxgloveServer"]
__getattr__ = lazy(__name__, {"PORT": "options", "FoxgloveServer": "server"})
