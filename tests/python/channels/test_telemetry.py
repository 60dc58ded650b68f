"""/telemetry: the panel's values in one message."""

import numpy as np

from uwsim import Simulator
from uwsim.channels import channels


def test_accelerations_are_the_rates_of_the_velocities_along_the_body_axes() -> None:
    sim = Simulator("pool")
    telemetry = next(channel for channel in channels(sim) if channel.name == "telemetry")
    sim.rov.undock()
    sim.rov.set_effort(surge=0.6, sway=-0.3, roll=0.4, yaw=0.5)
    sim.advance(1.5)

    def world_and_body() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        turn = np.array(sim.rov.pose.world_from_body[:3, :3])
        return turn, turn @ sim.rov.velocity.linear_body_m_s, np.array(sim.rov.velocity.angular_body_rad_s)

    _, velocity_m_s, rate_rad_s = world_and_body()
    sim.step()
    turn, velocity_after_m_s, rate_after_rad_s = world_and_body()
    message = telemetry.read(sim)
    linear = turn.T @ (velocity_after_m_s - velocity_m_s) / sim.step_s
    assert np.linalg.norm(linear) > 0.05
    np.testing.assert_allclose(message.linear_acceleration, linear, atol=0.01)
    np.testing.assert_allclose(message.angular_acceleration, (rate_after_rad_s - rate_rad_s) / sim.step_s, atol=0.01)
