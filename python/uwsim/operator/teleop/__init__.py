"""Teleoperation in the terminal: `uwsim teleop`. It needs the extra 'teleop'.

`connection` is a plain rosbridge client, `hands` turns keys and sticks into efforts, and the rest draws.
"""
