"""Published results reproduced: each figure as a picture of our own, with its values."""

from uwsim.evidence.reproduce.paper import reproduce_paper

__all__ = ["reproduce_paper"]
