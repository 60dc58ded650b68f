"""Fly a survey, score its map against the truth, and tell of it in pictures, a report and a table."""
