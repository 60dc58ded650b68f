"""Missions of ground stations and charts."""
