"""The engine under validation."""

from contextvars import ContextVar

ENGINE = ContextVar("engine", default="uwsim")
"""The `dynamics.engine` of the scenarios in the dynamics suite."""
