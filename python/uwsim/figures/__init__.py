"""Figures: PNG files of surveys, maps and sonars. Nothing here flies or scores."""
