"""The exit codes of `uwsim`; 2 is typer's own for wrong options."""

FAILED, STUCK, INTERRUPTED = 1, 3, 130
