"""Teleoperation in the terminal, by keys and numbers: `uwsim teleop`. Needs the extra 'teleop'."""
