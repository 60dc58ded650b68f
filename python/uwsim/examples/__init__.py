"""Short programs to copy, numbered in reading order; each runs with `python -m uwsim.examples.<name>`."""
