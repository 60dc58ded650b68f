"""Grades of instruments: the parameters of a kind of sensor by the name that data sheets use for a class of them.

Inertial navigation systems, after El-Sheimy and Youssef 2020, "Inertial sensors technologies for navigation
applications: state of the art and future trends", Satellite Navigation 1:2, table 1, which has a position error of 1
nautical mile per hour and gyroscopes below 0.01 deg/h and 0.002 deg/sqrt(h) for navigation; 10 to 20 nautical miles per
hour and 1 to 10 deg/h, 0.02 to 0.05 deg/sqrt(h) for tactical; 0.1 deg/s and several deg/sqrt(h) for mems, there called
commercial; accelerometers of up to 100 ug for navigation, 1 to 5 mg for the lowest class. Values within these ranges,
and those of accelerometers' noise and alignment, are assumed: an alignment at rest levels to bias / g, and finds north
to the gyroscopes' bias over the horizontal part of the Earth's rotation, 0.01 deg/h / (15 deg/h cos 45 deg) = 0.05 deg;
the others take their heading from elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping

INS = (
    "gyro_bias_deg_h", "gyro_random_walk_deg_sqrt_h", "accelerometer_bias_ug", "accelerometer_noise_ug_sqrt_hz",
    "tilt_std_deg", "heading_std_deg",
)  # fmt: skip

GRADES: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "ins": {
        "navigation": dict(zip(INS, (0.01, 0.002, 50.0, 10.0, 0.003, 0.05), strict=True)),
        "tactical": dict(zip(INS, (1.0, 0.05, 500.0, 50.0, 0.03, 0.5), strict=True)),
        "mems": dict(zip(INS, (360.0, 2.0, 3000.0, 150.0, 0.2, 2.0), strict=True)),
    },
}
"""By kind of sensor and grade."""
