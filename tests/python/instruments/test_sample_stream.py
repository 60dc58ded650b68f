"""A stream yields each sample of a sensor once, when it arrives."""

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.instruments import sample_stream


@pytest.fixture
def sim() -> Simulator:
    sim = Simulator("pool", seed=5)
    sim.rov.undock()
    return sim


def test_every_sample_comes_once_whenever_they_are_taken(sim: Simulator) -> None:
    often, at_once = ({name: s.stream() for name, s in sim.rov.sensors.items()} for _ in range(2))
    taken = {name: [] for name in often}
    sim.rov.set_effort(surge=0.5, yaw=0.2)
    for steps in (1, 7, 400, 3, 189):
        sim.step(steps)
        for name, stream in often.items():
            taken[name].append(stream.take().readings)
    for name, stream in at_once.items():
        assert np.array_equal(np.concatenate(taken[name]), stream.take().readings, equal_nan=True), name


def test_samples_are_those_that_reads_give_and_dropped_ones_do_not_come(sim: Simulator) -> None:
    dvl = sim.rov.sensors["dvl"]
    stream, read = dvl.stream(), {}
    for _ in range(600):
        sim.step()
        sample = dvl.sample()
        if sample.valid:
            read[sample.stamp_ns] = sample.value.velocity_m_s
    samples = stream.take()
    new = samples.stamps_ns.tolist()
    assert len(new) == len(set(new)) > 10 and set(read) - {0} <= set(new)
    assert all((samples.readings[k, :3] == read[stamp]).all() for k, stamp in enumerate(new) if stamp in read)
    latency_s = sim.scenario.vehicles[0].model.sensors["dvl"].latency_s
    assert (samples.arrivals_ns - samples.stamps_ns == round(latency_s * 1e9)).all() and latency_s > 0.0
    sim.parameters["rov.sensors.dvl.drop_out"] = 0.5
    sim.advance(40.0)
    assert 0.3 < len(stream.take()) / 200 < 0.7


def test_streams_survive_a_change_of_parameters_but_not_a_reset(sim: Simulator) -> None:
    stream = sim.rov.sensors["depth"].stream()
    sim.advance(1.0)
    sim.parameters["rov.sensors.depth.noise.std"] = 0.5
    sim.advance(1.0)
    readings = stream.take().readings[:, 0]
    assert len(readings) == 40 and np.std(readings[21:]) > 5 * np.std(readings[:19])
    sim.reset()
    with pytest.raises(ValueError, match="the stream has ended"):
        stream.take()


@pytest.mark.parametrize("taken", [False, True])
def test_a_stream_begins_with_the_present_sample_whether_or_not_another_has_taken_it(
    sim: Simulator, taken: bool
) -> None:
    sim.step(10)
    imu, now_ns = sim.rov.sensors["imu"], sim.time_ns
    others = [imu.stream(), imu.stream(now_ns)]
    if taken:
        others[0].take()
    stream = imu.stream(now_ns)
    sim.step(2)
    stamps_ns = [now_ns + 5_000_000 * k for k in range(3)]
    assert stream.take().stamps_ns.tolist() == others[1].take().stamps_ns.tolist() == stamps_ns
    assert others[0].take().stamps_ns[0] > now_ns


def test_a_stream_keeps_the_newest_and_counts_what_it_dropped(sim: Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also while nothing is taken from the sensor's other streams, and whatever the lengths of the steps."""
    monkeypatch.setattr(sample_stream, "KEPT", 250)
    monkeypatch.setattr(sample_stream, "JOINED", 10)
    monkeypatch.setattr(sample_stream, "EVERY_STEPS", 100)
    imu = sim.rov.sensors["imu"]
    stays, taken, whole = imu.stream(), imu.stream(), []
    for steps in (1, 1, 1, 300, 7, 90, 250, *[1] * 40):
        sim.step(steps)
        whole.append(taken.take())
    sim.step(3000)
    native = sim._core.take_samples(0, list(sim.rov.sensors).index("imu"))
    assert len(native[0]) <= 100  # the rest has been delivered
    kept = stays.take()
    assert len(kept) == 250 and kept.stamps_ns[-1] > whole[-1].stamps_ns[-1]
    assert (np.diff(kept.stamps_ns.astype(np.int64)) == round(imu.period_s * 1e9)).all()
    assert stays.dropped + 250 == sum(map(len, whole)) + len(taken.take()) + taken.dropped
    del stays, taken
    sim.step(200)
    assert sim.agenda.is_empty
