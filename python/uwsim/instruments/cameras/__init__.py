"""Cameras and lamps: pictures of the world at the current time, seen through the scenario's water."""

from uwsim.instruments.cameras.camera import Camera
from uwsim.instruments.cameras.effects import EFFECTS
from uwsim.instruments.cameras.frame import CameraInfo, Frame
from uwsim.instruments.cameras.lamp import Lamp

__all__ = ["EFFECTS", "Camera", "CameraInfo", "Frame", "Lamp"]
