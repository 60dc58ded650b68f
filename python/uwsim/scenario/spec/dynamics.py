"""Dynamics: the engine that moves the vehicles."""

from __future__ import annotations

from typing import Literal

from uwsim.scenario.spec.fields import Model


class Dynamics(Model):
    """The engine that moves the vehicles.

    engine: `uwsim` integrates with the full mass matrix and solves contacts with it; `bullet` is Bullet's own dynamics,
    with the added mass folded into mass and inertia.
    """

    engine: Literal["uwsim", "bullet"] = "uwsim"
