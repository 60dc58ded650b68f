"""Leave the dock, dive, read the telemetry and ping."""

import numpy as np

import uwsim


def main() -> None:
    """Fly for half a minute and print the sonar's echoes."""
    with uwsim.Simulator("lake", seed=7) as sim:
        rov = sim.rov
        rov.release()
        for efforts in ({"surge": 0.5}, {"surge": 0.3, "heave": -0.8}, {"yaw": 0.4}):
            rov.set_effort(**efforts)
            sim.advance(10.0)
            panel = rov.telemetry()
            print(f"{sim.time_s:4.0f} s: {panel.depth_m:5.2f} m deep, {panel.speed_m_s:.2f} m/s, {efforts}")

        rov.sonar.aim(elevation_rad=-0.7)
        sim.advance(3.0)  # the head turns at 5 degrees per second
        ping = rov.sonar.ping()
        names = [sim.label_names[label] for label in np.unique(ping.labels[ping.valid])]
        print(f"{ping.valid.sum()} of {len(ping.ranges_m)} beams came back, from: {', '.join(names)}")


if __name__ == "__main__":
    main()
