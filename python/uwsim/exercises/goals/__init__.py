"""The kinds of goals, one file each; see uwsim.exercises.goal."""
