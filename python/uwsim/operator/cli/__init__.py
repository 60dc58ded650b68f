"""Commands for the station, exercises and teleop."""
