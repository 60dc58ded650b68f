"""Films: pictures of a recorded run from any camera, with many rays a pixel, and their encoding."""

from uwsim.campaigns.film.make import QUALITIES, Film, make_film

__all__ = ["QUALITIES", "Film", "make_film"]
