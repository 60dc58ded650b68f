"""One of each thing that a package can add to uwsim; docs/inside/extend.md explains it."""
