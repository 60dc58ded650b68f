"""Published results made again: each figure as our own picture, with the values behind it."""

from uwsim.reproduce.paper import reproduce_paper

__all__ = ["reproduce_paper"]
