#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// Gate of the outlier test: a scalar farther than this many standard deviations from its expected value (Mahalanobis
/// distance) is an outlier. Rejects one good reading in 1.7 million.
inline constexpr double kGate = 5;
/// After this many consecutive readings with outliers, the filter assumes that the error is its own and increases its
/// uncertainty accordingly. A reading counts if at least a third of its scalars are outliers: two of a DVL's four
/// beams, which is how an error between them appears, but not one, which may be a single bad beam.
inline constexpr std::uint64_t kReadingsBeforeDoubt = 5;
inline constexpr int kMaxReading = 8;

/// An instrument that corrects the filter. Lever arms are from the IMU, body axes.
class Aid {
 public:
  virtual ~Aid() = default;
  /// The number of values in a reading.
  virtual int width() const = 0;
  /// Models of the aid's biases, which become error states of the filter.
  virtual std::vector<BiasModel> biases() const { return {}; }
  /// The number of biases, from the first, that are included in a saved state of version 1.
  virtual int biases_in_version_1() const { return static_cast<int>(biases().size()); }
  /// Index of the first of the three errors that the aid observes, and that are inflated when the filter doubts itself.
  virtual ErrorIndex seen() const = 0;
  /// Corrects `state` with a reading (width(),), one scalar at a time.
  virtual void correct(FilterState& state, const double* reading) const = 0;
  /// Saves or restores its parameters. Throws InvalidValue.
  virtual void exchange_figures(StateArchive& archive) = 0;

  /// Positions of the aid's counts and biases in the state; set by NavigationFilter.
  int index = 0, first_bias = 0;

 protected:
  /// Applies one scalar: residual = h . error + white noise of `variance`. Joseph form. Returns false for an outlier.
  bool correct(FilterState& state, double residual, const ErrorVector& h, double variance) const;
};

/// Velocities along beams, (n,) [m/s]; NaN for a lost beam. `beams_body` (n, 3): unit vectors.
std::unique_ptr<Aid> doppler_aid(const Eigen::MatrixX3d& beams_body, const Eigen::Vector3d& lever_body_m, double std,
                                 const BiasModel& bias);
/// Depth, (1,) [m, positive down].
std::unique_ptr<Aid> depth_aid(const Eigen::Vector3d& lever_body_m, double std, const BiasModel& bias);
/// The angle of `axis_body` from east, counter-clockwise, (1,) [rad]; `north_rad`: the angle of magnetic north.
/// `iron_std`: the vehicle's own field along each body axis, as a fraction of the earth's horizontal field.
std::unique_ptr<Aid> heading_aid(const Eigen::Vector3d& axis_body, double std, const BiasModel& bias, double iron_std,
                                 double north_rad);
/// Position from a station along east, north and up, (3,) [m], with errors along and across the line of sight.
std::unique_ptr<Aid> acoustic_fix_aid(const Eigen::Vector3d& lever_body_m, const Eigen::Vector3d& station_world_m,
                                      double range_std, double bearing_std);
/// Orientation, world from body, x, y, z, w, (4,), with errors in body axes.
std::unique_ptr<Aid> orientation_aid(double std, const BiasModel& bias);

}  // namespace uwsim
