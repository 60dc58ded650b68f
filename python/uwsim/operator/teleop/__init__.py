"""Teleoperation in the terminal: `uwsim teleop`. Needs the extra 'teleop'.

`connection` is a plain rosbridge client, `hands` converts keys and sticks to efforts, and the other modules draw.
"""
