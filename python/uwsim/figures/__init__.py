"""Figures: a survey, a map and a sonar drawn as PNG files. Nothing here flies or scores."""
