"""Reproduces published results: each figure in the paper, as a picture drawn by uwsim with its values."""

from uwsim.evidence.reproduce.paper import reproduce_paper

__all__ = ["reproduce_paper"]
