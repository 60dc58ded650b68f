"""Flies a survey, maps what the sonar sees, scores the map, and writes a report. Start reading at run.py and fly.py."""
