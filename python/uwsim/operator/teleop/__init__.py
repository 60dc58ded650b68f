"""Teleoperation in the terminal: `uwsim teleop`. Needs the extra 'teleop'.

`connection` is a plain rosbridge client, `hands` turns keys and sticks into efforts, and the other modules draw.
"""
