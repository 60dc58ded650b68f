"""`python -m uwsim`: the `uwsim` command, for example where its script is not on the path."""

from uwsim.cli import main

main()
