"""Cameras and lamps: pictures of the world at the present time, in the light that the water transmits."""

from uwsim.cameras.camera import Camera
from uwsim.cameras.effects import EFFECTS
from uwsim.cameras.frame import CameraInfo, Frame
from uwsim.cameras.lamp import Lamp

__all__ = ["EFFECTS", "Camera", "CameraInfo", "Frame", "Lamp"]
