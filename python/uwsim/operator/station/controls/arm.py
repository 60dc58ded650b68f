"""The pilot's hold-to-move of an arm: joint by joint, its hand along a camera's axes, and the jaws of its gripper."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from concurrent.futures import Future
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arguments import is_number
from uwsim.base.quaternions import turned
from uwsim.channels.authority.steering import Steering, nothing_done
from uwsim.channels.guest import Values
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.simulator.arm import Arm
from uwsim.simulator.helm import Timeout
from uwsim.simulator.simulator import Simulator

HAND_M_S = 0.1
"""The speed of the hand at a share of 1."""
RETRY_S = 0.05

Speeds = dict[str, float]


class Motion(NamedTuple):
    """A checked request.

    joints: shares of their fastest speeds. hand: (3,), shares of HAND_M_S ahead, to the left and up in the picture of a
    camera, or on the vehicle where that is "". grip: the share with which the jaws close.
    """

    joints: Speeds
    hand: NDArray[np.float64]
    camera: str
    grip: float


class ArmPilot:
    """Moves the arms of one simulator for as long as the pilot's page repeats what it asks for.

    What is asked for no longer stops, but jaws that press on something go on pressing, as the screw of a gripper does.
    live: the simulator. far: the same as commanded by the pilot, perhaps over a link; then only joints and jaws are
    moved, because where the arm is is not known ashore. silence: ends all motion; its owner renews it.
    """

    def __init__(
        self,
        live: LiveSimulator,
        far: LiveSimulator,
        steering: Mapping[str, Steering],
        silence: Timeout,
    ) -> None:
        self._live, self._far, self._steering, self.silence = live, far, steering, silence
        self._lock = threading.Lock()
        self._moving: dict[str, Speeds] = {}  # what was last asked of joints that are to stop, by vehicle

    def move(self, vehicle: str, request: Values) -> Future[object]:
        """Move an arm as requested (docs/connections/station-wire.md). Raises ValueError."""
        arm = self._arm(vehicle)
        motion = _motion(request, arm)
        if motion.hand.any() and self._far is not self._live:
            raise ValueError("hand: it cannot be moved over a link: where the arm is is not known here")
        if motion.hand.any() and not arm.can_jog:
            raise ValueError(
                f"hand: fewer than two motors move it: {', '.join(arm.motors)} must be moved by themselves"
            )
        if motion.camera and motion.camera not in self._live.simulator.vehicles[vehicle].cameras:
            raise ValueError(f"camera = {motion.camera[:40]!r}: '{vehicle}' has no such camera")
        return self._command(vehicle, motion)

    def beat(self, now_ns: int) -> float:
        """Stop what is asked for no longer. Return the time [s] until the next check."""
        with self._lock:
            moving = [vehicle for vehicle, speeds in self._moving.items() if speeds]
        if not moving:
            return math.inf
        if left_ns := self.silence.left_ns(now_ns):
            return max(1e-9 * left_ns, RETRY_S)
        return RETRY_S if self.stop() else math.inf

    def stop(self) -> bool:
        """Stop all motion. Return whether that must be tried again, because the simulator takes no command now."""
        with self._lock:
            moving = [vehicle for vehicle, speeds in self._moving.items() if speeds]
        for vehicle in moving:
            try:
                self._command(vehicle, Motion({}, np.zeros(3), "", 0.0))
            except (NotRunningError, RuntimeError):
                return True
        return False

    def _command(self, vehicle: str, motion: Motion) -> Future[object]:
        """Read where the arm is, and command its joints by that."""
        commanded: Future[object] = Future()

        def command(read: Future[tuple[Speeds, Speeds]]) -> None:  # on the simulator's thread
            try:
                moving, stopping = read.result()
                speeds = moving | stopping
                done = self._steering[vehicle].ask(self._far, "set_joints", speeds=speeds) if speeds else nothing_done()
                with self._lock:
                    self._moving[vehicle] = moving  # only now: else what could not be stopped would be forgotten
                done.add_done_callback(lambda done: _pass(done, commanded))
            except (ValueError, RuntimeError) as error:
                commanded.set_exception(error)

        self._live.read(lambda sim: self._speeds(sim, vehicle, motion)).add_done_callback(command)
        return commanded

    def _speeds(self, sim: Simulator, vehicle: str, motion: Motion) -> tuple[Speeds, Speeds]:
        """Return the speeds [rad/s or m/s] of the joints that are to move, and of those that are to stop."""
        arm, limits = self._arm(vehicle), self._arm(vehicle).speed_limits
        wanted = {name: share * limits[name] for name, share in motion.joints.items() if share}
        if motion.hand.any():
            velocity = HAND_M_S * motion.hand
            if motion.camera:
                velocity = turned(sim.vehicles[vehicle].cameras[motion.camera].mounting_xyzw(), velocity)
            wanted |= {name: speed for name, speed in arm.jog(velocity).items() if name not in wanted}
        if motion.grip:
            wanted |= {name: motion.grip * closes * limits[name] for name, closes in arm.jaws.items()}
        with self._lock:
            before = self._moving.get(vehicle, {})
        held = {name for name, speed in before.items() if self._holds(arm, name, speed)}
        return wanted, {name: 0.0 for name in before if name not in wanted and name not in held}

    def _holds(self, arm: Arm, joint: str, speed: float) -> bool:
        """Return whether a jaw is to go on as it was: it closes on something, or over a link, where that is unknown."""
        is_closing = speed * arm.jaws.get(joint, 0.0) > 0.0
        return is_closing and (self._far is not self._live or arm.is_pressing(joint))

    def _arm(self, vehicle: str) -> Arm:
        arm = self._live.simulator.vehicles[vehicle].arm
        if arm is None or not arm.motors:
            raise ValueError(f"vehicle = {vehicle!r}: it has no arm with motors")
        return arm


def _motion(request: Values, arm: Arm) -> Motion:
    joints, hand, camera = request.get("joints") or {}, request.get("hand") or [0, 0, 0], request.get("camera") or ""
    if not isinstance(joints, dict):
        raise ValueError(f"joints = {str(joints)[:40]}: must be shares by name")
    for name in joints:
        if name not in arm.motors:
            raise ValueError(f"joints.{str(name)[:40]}: must be one of {', '.join(arm.motors)}")
    if not isinstance(hand, list) or len(hand) != 3:
        raise ValueError(f"hand = {str(hand)[:40]}: must be three shares: ahead, to the left, up")
    if not isinstance(camera, str):
        raise ValueError(f"camera = {str(camera)[:40]}: must be a name")
    shares = {f"joints.{name}": share for name, share in joints.items()}
    shares |= {f"hand[{k}]": share for k, share in enumerate(hand)} | {"grip": request.get("grip") or 0.0}
    for name, share in shares.items():
        if not is_number(share) or not -1.0 <= share <= 1.0:
            raise ValueError(f"{name} = {str(share)[:40]}: must be in [-1, 1]")
    if shares["grip"] and not arm.jaws:
        raise ValueError(f"grip = {shares['grip']:g}: the arm has no jaws")
    return Motion({str(k): float(v) for k, v in joints.items()}, np.array(hand, float), camera, float(shares["grip"]))


def _pass(done: Future[object], on: Future[object]) -> None:
    """Pass the outcome of a future on to another."""
    error = None if done.cancelled() else done.exception()
    if error is not None:
        on.set_exception(error)
    else:
        on.set_result(None)
