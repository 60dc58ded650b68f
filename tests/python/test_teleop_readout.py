"""What the pilot's terminal reads of the vehicle's panel."""

import numpy as np
import pytest

from uwsim.channels.messages import default_message
from uwsim.teleop.readout import Readout, take_telemetry


@pytest.mark.parametrize("is_truth", [True, False])
def test_the_place_is_the_true_one_where_it_may_be_seen(is_truth):
    message = default_message("uwsim_msgs/msg/Telemetry")
    message.is_truth, message.position, message.true_position = is_truth, np.array([1.0, 2, 3]), np.array([4.0, 5, 6])
    readout = Readout()
    take_telemetry(readout, message)
    assert readout.position_m == ((4.0, 5.0, 6.0) if is_truth else (1.0, 2.0, 3.0))
