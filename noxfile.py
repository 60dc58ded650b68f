#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""The scripts of tools/ as sessions of nox: `nox -l` lists them. Each calls tools/setup, which installs into .venv."""

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "none"


def _script(session: nox.Session, *command: str) -> None:
    session.run(*command, *session.posargs, external=True)


@nox.session
def lint(session: nox.Session) -> None:
    """Run every check that needs no simulation."""
    _script(session, "tools/lint")


@nox.session
def tests(session: nox.Session) -> None:
    """Run the native tests, then the Python tests; options go to pytest."""
    _script(session, "tools/test")


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """Build the site."""
    _script(session, "tools/docs")


@nox.session(default=False)
def wheel(session: nox.Session) -> None:
    """Build a wheel for each interpreter given, and try it in an empty system."""
    _script(session, "tools/wheel")


@nox.session(default=False)
def ci(session: nox.Session) -> None:
    """Run all checks that must pass before a change is shared."""
    _script(session, "bash", ".ci/run")


if __name__ == "__main__":
    nox.main()
