"""Films: pictures of a recorded run from any camera, with many rays a pixel, and their encoding."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.campaigns.film.make import Film, make_film

__all__ = ["Film", "make_film"]
__getattr__ = lazy(__name__, dict.fromkeys(__all__, "make"))
