"""Flies any mission in a simulator: log, samples, map, score, report, autosave. Start reading at fly.py."""
