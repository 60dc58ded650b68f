"""The values that the pilot's terminal displays from the vehicle's panel."""

import numpy as np
import pytest

from uwsim.channels.ros.messages import default_message
from uwsim.operator.teleop.readout import Readout, read_link, read_telemetry


@pytest.mark.parametrize("is_truth", [True, False])
def test_the_place_is_the_true_one_where_it_may_be_seen(is_truth):
    message = default_message("uwsim_msgs/msg/Telemetry")
    message.is_truth, message.position, message.true_position = is_truth, np.array([1.0, 2, 3]), np.array([4.0, 5, 6])
    readout = Readout()
    read_telemetry(readout, message)
    assert readout.position_m == ((4.0, 5.0, 6.0) if is_truth else (1.0, 2.0, 3.0))


def test_the_pilot_reads_how_the_link_is_and_nothing_where_there_is_none():
    message = default_message("uwsim_msgs/msg/Link")
    readout = Readout()
    message.modem, message.fault_loss = "none", 1.0
    read_link(readout, message)
    assert (readout.link, readout.link_fault) == ("", "LINK DOWN")
    message.modem, message.quality, message.delay, message.silence_at_station = "s2cm_hs", 0.83, 0.041, 12.4
    message.fault_loss = 0.5
    read_link(readout, message)
    assert (readout.link, readout.link_fault) == ("s2cm_hs 83% 41 ms, 12 s ago", "LINK LOSES 50%")
    message.fault_loss, message.delay = 0.0, float("nan")
    read_link(readout, message)
    assert (readout.link, readout.link_fault) == ("s2cm_hs 83%, 12 s ago", "")
