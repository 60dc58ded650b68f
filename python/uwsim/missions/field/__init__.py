"""Missions of the field: files of ground stations and charts, read into items as MAVLink has them."""

from uwsim.missions.field.mission import Area, FieldFileError, FieldMission, Item, is_mission_file, read_mission_file

__all__ = ["Area", "FieldFileError", "FieldMission", "Item", "is_mission_file", "read_mission_file"]
