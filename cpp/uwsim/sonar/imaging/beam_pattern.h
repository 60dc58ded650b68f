#pragma once

namespace uwsim {

/// Power pattern of a line array; two-way if it represents transmitter and receiver together.
///
/// The aperture is weighted by a raised cosine on a pedestal, (1 - taper) + taper cos(2 pi x), -1/2 <= x <= 1/2, so
/// that
///   H(u) = sinc(u) + taper / (2 (1 - taper)) (sinc(u - 1) + sinc(u + 1)),   u = sin(off axis) L / lambda,
/// (Harris 1978, "On the use of windows for harmonic analysis with the discrete Fourier transform", Proc. IEEE 66:51).
/// A taper of 0 means no shading, with side lobes at -13.3 dB; 0.46 is Hamming's, at -43 dB. L / lambda follows from
/// the width.
class BeamPattern {
 public:
  /// width_rad: full width between half-power points, in (0, pi]. taper: [0, 0.5]. floor: lower limit of the power,
  /// representing the leakage around a real transducer; [0, 1). Throws InvalidValue.
  BeamPattern(double width_rad, double taper, double floor);

  /// Power relative to the axis, in [floor, 1]. Beyond +-pi/2, the value at pi/2 is used.
  double power(double off_axis_rad) const;
  /// H at an angle, relative to the axis; side lobes alternate in sign, and there is no floor.
  double amplitude_at(double off_axis_rad) const;
  /// L / lambda.
  double lengths_per_wave() const { return lengths_per_wave_; }

 private:
  double amplitude(double u) const;

  double taper_;
  double floor_;
  double lengths_per_wave_ = 0;
};

}  // namespace uwsim
