"""Reproduces the figures in the paper: each is drawn by uwsim, together with its values."""

from uwsim.evidence.reproduce.paper import reproduce_paper

__all__ = ["reproduce_paper"]
