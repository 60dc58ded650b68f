"""The exit codes of `uwsim`, used by the commands, `uwsim --help` and docs/guides/conventions.md."""

from __future__ import annotations

OK, FAILED, USAGE, STUCK, INCOMPLETE, INTERRUPTED = 0, 1, 2, 3, 4, 130

EXIT_CODES = {
    OK: "success",
    FAILED: "an error, or a check that failed: validate, ros doctor, recording diff, map diff --exit-code, "
    "--verify-map, sweep, fleet",
    USAGE: "an unknown command, option or value, a number out of bounds, or an option that would have no effect",
    STUCK: "survey, run: the vehicle was stuck or capsized",
    INCOMPLETE: "survey, run: coverage is below --min-coverage, or a mission without a plan ended early; exercise: "
    "not passed; replay: the recording was cut off",
    INTERRUPTED: "interrupted by Ctrl-C, SIGTERM or SIGHUP; serve and station exit with 0 instead once they "
    "are running",
}
"""The meaning of each code; USAGE is typer's."""


def exit_code_help() -> str:
    """Return the table as text for --help, marked so that its lines are not joined."""
    rows = (f"{code:>5}  {meaning}" for code, meaning in EXIT_CODES.items())
    return "\b\nExit codes:\n" + "\n".join(rows)
