"""Layouts of Kongsberg's EM datagrams in .kmall files: little-endian, without padding but the named.

From Kongsberg Maritime's public description EMdgmFormat, Rev F of 2018-10-17; the structures of later revisions have
more at their ends, and the lengths are in the file. Angles in degrees: roll starboard down, pitch bow up, heading
clockwise from north, a beam's angle about the receiver's forward axis, positive to port. Axes forward, starboard, down.
"""

from __future__ import annotations

import numpy as np

HEADER = np.dtype([
    ("bytes", "<u4"), ("type", "S4"), ("version", "u1"), ("system", "u1"), ("sounder", "<u2"), ("s", "<u4"),
    ("ns", "<u4"),
])  # fmt: skip
TEXT = np.dtype([("bytes", "<u2"), ("info", "<u2"), ("status", "<u2")])
"""Begins the body of #IIP; a text of the rest of `bytes` follows."""
SENSOR = np.dtype([("bytes", "<u2"), ("system", "<u2"), ("status", "<u2"), ("padding", "<u2")])
POSITION = np.dtype([
    ("s", "<u4"), ("ns", "<u4"), ("quality_m", "<f4"), ("latitude_deg", "<f8"), ("longitude_deg", "<f8"),
    ("speed_m_s", "<f4"), ("course_deg", "<f4"), ("height_m", "<f4"),
])  # fmt: skip
ATTITUDES = np.dtype([
    ("bytes", "<u2"), ("system", "u1"), ("status", "u1"), ("input", "<u2"), ("samples", "<u2"),
    ("bytes_per_sample", "<u2"), ("contents", "<u2"),
])  # fmt: skip
ATTITUDE = np.dtype([
    ("type", "S4"), ("bytes", "<u2"), ("version", "<u2"), ("s", "<u4"), ("ns", "<u4"), ("status", "<u4"),
    ("latitude_deg", "<f8"), ("longitude_deg", "<f8"), ("height_m", "<f4"), ("roll_deg", "<f4"), ("pitch_deg", "<f4"),
    ("heading_deg", "<f4"), ("heave_m", "<f4"), ("rates_deg_s", "<f4", 3), ("velocity_m_s", "<f4", 3),
    ("errors", "<f4", 7), ("acceleration_m_s2", "<f4", 3), ("heave_s", "<u4"), ("heave_ns", "<u4"),
    ("delayed_heave_m", "<f4"),
])  # fmt: skip
PROFILE = np.dtype([
    ("bytes", "<u2"), ("levels", "<u2"), ("format", "S4"), ("s", "<u4"), ("latitude_deg", "<f8"),
    ("longitude_deg", "<f8"),
])  # fmt: skip
LEVEL = np.dtype([
    ("depth_m", "<f4"), ("speed_m_s", "<f4"), ("padding", "<u4"), ("temperature_deg_c", "<f4"), ("salinity", "<f4"),
])  # fmt: skip
PARTITION = np.dtype([("of", "<u2"), ("number", "<u2")])
BODY = np.dtype([
    ("bytes", "<u2"), ("ping", "<u2"), ("fans", "u1"), ("fan", "u1"), ("swaths", "u1"), ("swath", "u1"),
    ("transmitter", "u1"), ("receiver", "u1"), ("receivers", "u1"), ("algorithm", "u1"),
])  # fmt: skip
PING = np.dtype([
    ("bytes", "<u2"), ("padding0", "<u2"), ("rate_hz", "<f4"), ("spacing", "u1"), ("depth_mode", "u1"),
    ("sub_depth_mode", "u1"), ("swath_distance", "u1"), ("detection_mode", "u1"), ("pulse_form", "u1"),
    ("padding1", "<u2"), ("frequency_hz", "<f4"), ("lowest_hz", "<f4"), ("highest_hz", "<f4"), ("pulse_s", "<f4"),
    ("effective_pulse_s", "<f4"), ("bandwidth_hz", "<f4"), ("absorption_db_km", "<f4"), ("port_edge_deg", "<f4"),
    ("starboard_edge_deg", "<f4"), ("port_coverage_deg", "<f4"), ("starboard_coverage_deg", "<f4"),
    ("port_coverage_m", "<i2"), ("starboard_coverage_m", "<i2"), ("stabilisation", "u1"), ("filter1", "u1"),
    ("filter2", "<u2"), ("pipe", "<u4"), ("transmit_size_deg", "<f4"), ("receive_size_deg", "<f4"),
    ("power_db", "<f4"), ("ramp_up", "<u2"), ("padding2", "<u2"), ("yaw_deg", "<f4"), ("sectors", "<u2"),
    ("bytes_per_sector", "<u2"), ("heading_deg", "<f4"), ("sound_speed_m_s", "<f4"), ("transducer_depth_m", "<f4"),
    ("water_level_m", "<f4"), ("x_to_all_m", "<f4"), ("y_to_all_m", "<f4"), ("position_method", "u1"),
    ("position_status", "u1"), ("attitude_status", "u1"), ("padding3", "u1"), ("latitude_deg", "<f8"),
    ("longitude_deg", "<f8"), ("height_m", "<f4"),
])  # fmt: skip
SECTOR = np.dtype([
    ("number", "u1"), ("array", "u1"), ("sub_array", "u1"), ("padding0", "u1"), ("delay_s", "<f4"),
    ("tilt_deg", "<f4"), ("source_level_db", "<f4"), ("focus_m", "<f4"), ("frequency_hz", "<f4"),
    ("bandwidth_hz", "<f4"), ("signal_s", "<f4"), ("shading", "u1"), ("form", "u1"), ("padding1", "<u2"),
])  # fmt: skip
RECEIVER = np.dtype([
    ("bytes", "<u2"), ("soundings", "<u2"), ("valid", "<u2"), ("bytes_per_sounding", "<u2"), ("column_hz", "<f4"),
    ("image_hz", "<f4"), ("normal_db", "<f4"), ("oblique_db", "<f4"), ("alarm", "<u2"), ("extra", "<u2"),
    ("extra_classes", "<u2"), ("bytes_per_class", "<u2"),
])  # fmt: skip
SOUNDING = np.dtype([
    ("index", "<u2"), ("sector", "u1"), ("kind", "u1"), ("method", "u1"), ("rejection1", "u1"), ("rejection2", "u1"),
    ("post", "u1"), ("class", "u1"), ("confidence", "u1"), ("padding", "<u2"), ("range_factor", "<f4"),
    ("quality_percent", "<f4"), ("vertical_deviation_m", "<f4"), ("horizontal_deviation_m", "<f4"),
    ("window_s", "<f4"), ("echo_s", "<f4"), ("column_beam", "<u2"), ("column_range", "<u2"),
    ("column_angle_deg", "<f4"), ("absorption_db_km", "<f4"), ("reflectivity1_db", "<f4"),
    ("reflectivity2_db", "<f4"), ("sensitivity_db", "<f4"), ("source_level_db", "<f4"), ("calibration_db", "<f4"),
    ("gain_db", "<f4"), ("angle_deg", "<f4"), ("angle_correction_deg", "<f4"), ("time_s", "<f4"),
    ("time_correction_s", "<f4"), ("latitude_deg", "<f4"), ("longitude_deg", "<f4"), ("z_m", "<f4"), ("y_m", "<f4"),
    ("x_m", "<f4"), ("incidence_deg", "<f4"), ("clean", "<u2"), ("image_start", "<u2"), ("image_centre", "<u2"),
    ("image_samples", "<u2"),
])  # fmt: skip
NORMAL = 0
"""The kind of a sounding; 1 is an extra detection, 2 a rejected one."""
PHASE = 2
"""The method of a sounding; 0 is none, 1 the amplitude."""
