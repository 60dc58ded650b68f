#pragma once

#include <optional>

#include "uwsim/acoustics/modem/boundary_loss.h"
#include "uwsim/acoustics/seabed.h"

/// The chapters of textbooks that are cited below have not been checked; the terms are tested one by one.
namespace uwsim {

/// The parameters of an active sonar: transmitter, receiver and detector. Levels are in dB: the source level re 1 uPa
/// at 1 m, the noise level re 1 uPa within the receiver's band.
struct SonarParameters {
  double frequency_hz = 400e3;
  double beam_width_along_rad = 0.007;  ///< -3 dB, one way: width of the transmitted beam, across the fan's plane
  /// -3 dB, one way: width of an unsteered receiving beam, within the fan's plane
  double beam_width_across_rad = 0.012;
  double pulse_length_s = 1e-4;
  double bandwidth_hz = 1e4;  ///< bandwidth of the pulse, which is compressed to 1 / bandwidth
  double source_level_db = 200;
  double directivity_index_db = 20;  ///< of an unsteered receiving beam, see steered_widening
  double noise_level_db = 45;
  double detection_threshold_db = 13;  ///< signal-to-noise ratio at which a single look is detected half of the time

  /// Throws InvalidValue naming sonar.<field>.
  void check() const;
  /// 10 log10 (bandwidth x pulse length), the gain from compressing a long pulse.
  double processing_gain_db() const;
  /// The signal-to-noise ratio of an echo without any losses, SL + PG + DI - NL [dB].
  double lossless_snr_db() const;
  /// Range resolution of the compressed pulse, c / (2 B) [m].
  double range_cell_m(double sound_speed_m_s) const;
  /// Equivalent solid angle of the two-way beam [sr]: the integral of the product of the two patterns. Both are assumed
  /// Gaussian, so this is pi / (4 ln 2) x the product of their widths.
  double beam_solid_angle_sr() const;
};

/// The factor by which steering widens the beam of a flat array: 1 / cos, because the projected length of the array is
/// shorter (van Trees 2002, "Optimum Array Processing", ch. 2). The directivity falls by the same factor, as the
/// projected area does (scan loss: Mahafza and Elsherbeni 2003, "MATLAB Simulations for Radar Systems Design", section
/// 8.6), so that the beam receives that much more of isotropic noise. Assumed: the array does not receive from behind,
/// and its other side is longer than a wavelength; the directivity of a line of omnidirectional elements would not
/// change. Steering beyond 80 degrees has no further effect (assumed: arrays are not used that way).
double steered_widening(double steering_rad);

/// The acoustic backscattering properties of a bottom.
struct BottomMaterial {
  double strength_db = -30;  ///< backscatter per square metre at normal incidence; other angles follow Lambert's law
  double relief = 0.1;       ///< rms slope of the relief across a footprint, which spreads the echo in range
  const Seabed* seabed = nullptr;          ///< if set, its backscatter by angle replaces Lambert's law
  FluidBottom fluid = {};                  ///< reflects sound that bounces more than once
  std::optional<double> ripples_rad = {};  ///< of the direction across ripples of sand, from x to y; see RippledBed
};

/// The geometry of a beam that hits a plane bottom.
struct BottomPlace {
  double range_m;
  double incidence_rad = 0;
  double steering_rad = 0;
};

/// The extent in range of a plane bottom's echo [m], due to the range cell, the relief and the slope of the footprint.
/// The relief contributes relief x width of the footprint x cos i, where the width is the geometric mean R sqrt(along x
/// across) (derived: the height of relief of a given slope is proportional to the footprint's width). The incidence i
/// within the fan's plane contributes sqrt(pi / (4 ln 2)) x width across x R tan i, the width of a rectangle that has
/// the same height and area as the Gaussian.
double echo_extent_m(const SonarParameters& sonar, const BottomMaterial& bottom, const BottomPlace& place,
                     double sound_speed_m_s);

/// The area of bottom that contributes to one range cell [m^2]. If the echo fits in a range cell, it is the footprint,
/// Omega R^2 / cos i (beam-limited, echoes fall by 20 log R); otherwise it is the fraction cell / extent of the
/// footprint (pulse-limited, 30 log R).
double echo_area_m2(const SonarParameters& sonar, const BottomMaterial& bottom, const BottomPlace& place,
                    double sound_speed_m_s);

/// Signal-to-noise ratio of a plane bottom's echo [dB] from the active sonar equation (Urick 1983, "Principles of
/// Underwater Sound", ch. 2 and 8) with Lambert's law: SL + PG + DI - NL + BS + 20 log cos i + 10 log A - 40 log R - 2
/// alpha R, with the DI of the steered beam.
double echo_snr_db(const SonarParameters& sonar, const BottomMaterial& bottom, const BottomPlace& place,
                   double sound_speed_m_s, double absorption_db_m);

}  // namespace uwsim
