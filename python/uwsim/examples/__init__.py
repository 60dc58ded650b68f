"""Short programs to copy from, numbered in reading order; each runs with `python -m uwsim.examples.<name>`."""
