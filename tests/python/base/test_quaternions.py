"""Our quaternion functions agree with SciPy's rotations."""

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from command_line import uwsim_process
from uwsim.base.quaternions import (
    about_x,
    about_y,
    about_z,
    heading_rad,
    matrix,
    of_matrix,
    of_yaw_pitch_roll_deg,
    product,
    turned,
)

TURNS = Rotation.random(20, rng=np.random.default_rng(1))


def same(quaternion: np.ndarray, turn: Rotation) -> bool:
    return bool((Rotation.from_quat(quaternion) * turn.inv()).magnitude() < 1e-12)


def test_products_and_turns_about_axes_are_those_of_scipy() -> None:
    for first, then in zip(TURNS[:10], TURNS[10:], strict=True):
        assert same(product(first.as_quat(), then.as_quat()), first * then)
    for angle_rad in (-3.0, 0.0, 0.4, 3.1):
        assert same(about_x(angle_rad), Rotation.from_euler("x", angle_rad))
        assert same(about_y(angle_rad), Rotation.from_euler("y", angle_rad))
        assert same(about_z(angle_rad), Rotation.from_euler("z", angle_rad))


def test_a_matrix_is_turned_into_its_quaternion_at_half_turns_too() -> None:
    half_turns = [Rotation.from_quat(np.eye(4)[axis]) for axis in range(4)]
    for turn in (*TURNS, *half_turns, *(each * Rotation.from_euler("xyz", (1e-9, -1e-9, 1e-9)) for each in half_turns)):
        assert same(of_matrix(turn.as_matrix()), turn)


def test_headings_mountings_matrices_and_turned_points_are_those_of_scipy() -> None:
    points = np.random.default_rng(2).normal(size=(7, 3))
    for turn in TURNS:
        x, y, _ = turn.apply((1.0, 0.0, 0.0))
        assert heading_rad(turn.as_quat()) == pytest.approx(np.arctan2(y, x), abs=1e-12)
        quaternion = of_yaw_pitch_roll_deg(turn.as_euler("ZYX", degrees=True))
        assert same(quaternion, turn)
        np.testing.assert_allclose(matrix(quaternion), turn.as_matrix(), atol=1e-12)
        for some in (points, points[0]):
            np.testing.assert_allclose(turned(quaternion, some), turn.apply(some), atol=1e-12)


def test_simulator_and_survey_are_imported_without_scipy_and_message_types() -> None:
    """Importing SciPy would take longer than creating a simulator."""
    program = (
        "import sys, uwsim.simulator.simulator, uwsim.live, uwsim.flight.survey\n"
        "sys.exit(', '.join({'scipy', 'rosbags'} & sys.modules.keys()) or 0)"
    )
    assert uwsim_process(command=[sys.executable, "-c", program]).stderr == ""
