"""Flies any mission in a simulator, with log, samples, map, score, report and autosave. Start reading at fly.py."""
