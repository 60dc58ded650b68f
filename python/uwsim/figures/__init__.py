"""Figures: PNG files of surveys, maps and sonars. This package only draws."""
