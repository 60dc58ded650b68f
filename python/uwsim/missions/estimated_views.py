"""Sonars and cameras whose readings are georeferenced by the vehicle's estimated pose instead of the true one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.navigation.control.protocols import PoseLike


def believed(world_from_part: NDArray[np.float64], truth: PoseLike, estimate: PoseLike) -> NDArray[np.float64]:
    """Return a vehicle sensor's world pose (4, 4), assuming that the vehicle is at its estimated pose."""
    true_body, body = np.asarray(truth.world_from_body), np.asarray(estimate.world_from_body)
    return np.asarray(body @ np.linalg.inv(true_body) @ world_from_part, np.float64)


class EstimatedPing:
    """A ping placed at its estimated pose; all other attributes are forwarded to the ping."""

    def __init__(self, ping: Any, world_from_sonar: NDArray[np.float64]) -> None:
        self._ping, self.world_from_sonar = ping, world_from_sonar

    def __getattr__(self, name: str) -> Any:
        return getattr(self._ping, name)


class EstimatedSonar:
    """A sonar on a vehicle that relies on its estimate; all attributes except `ping` are forwarded to the sonar."""

    def __init__(self, sonar: Any, hull: Any, estimate: Any) -> None:
        self._sonar, self._hull, self._estimate = sonar, hull, estimate

    def ping(self) -> EstimatedPing:
        """Send a ping; see uwsim.instruments.sonars.multibeam."""
        ping = self._sonar.ping()
        return EstimatedPing(ping, believed(ping.world_from_sonar, self._hull.pose, self._estimate.pose))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sonar, name)


class EstimatedImagingSonar:
    """An imaging sonar on a vehicle that relies on its estimate; its pings differ only in their poses."""

    def __init__(self, sonar: Any, hull: Any, estimate: Any) -> None:
        self._sonar, self._hull, self._estimate = sonar, hull, estimate

    @property
    def world_from_sonar(self) -> NDArray[np.float64]:
        """The sonar's estimated pose (4, 4)."""
        return believed(self._sonar.world_from_sonar, self._hull.pose, self._estimate.pose)

    def ping(self, *arguments: Any, **options: Any) -> Any:
        """Ping once; see uwsim.instruments.sonars.mounted.ImagingSonar. `look`, `line` and `profile` ping, too."""
        return self._placed(self._sonar.ping(*arguments, **options))

    def look(self, **options: Any) -> Any:
        """Return a picture from a forward-looking sonar."""
        return self._placed(self._sonar.look(**options))

    def line(self, **options: Any) -> Any:
        """Return one side-scan sonar ping."""
        return self._placed(self._sonar.line(**options))

    def profile(self, angles_rad: Any, **options: Any) -> Any:
        """Return single-beam pings at angles (n,)."""
        return self._placed(self._sonar.profile(angles_rad, **options))

    def _placed(self, found: Any) -> Any:
        pose = believed(found.world_from_sonar, self._hull.pose, self._estimate.pose)
        return replace(found, world_from_sonar=pose)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sonar, name)


class EstimatedCamera:
    """A camera on a vehicle that relies on its estimate; its frames differ from the camera's only in their poses."""

    def __init__(self, camera: Any, hull: Any, estimate: Any) -> None:
        self._camera, self._hull, self._estimate = camera, hull, estimate

    def capture(self, *arguments: Any, **options: Any) -> Any:
        """Capture a picture; see uwsim.instruments.cameras.Camera."""
        frame = self._camera.capture(*arguments, **options)
        pose = believed(frame.world_from_camera, self._hull.pose, self._estimate.pose)
        return replace(frame, world_from_camera=pose)

    def resized(self, *arguments: Any, **options: Any) -> EstimatedCamera:
        """Return the same camera with a different picture size."""
        return EstimatedCamera(self._camera.resized(*arguments, **options), self._hull, self._estimate)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._camera, name)
