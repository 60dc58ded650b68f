#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// Gate of the outlier test: a scalar that differs from its expected value by more than this many standard deviations
/// (Mahalanobis distance) is an outlier. The gate rejects one good scalar in 1.7 million.
inline constexpr double kGate = 5;
/// After this many consecutive readings with outliers, the filter assumes that its own state is wrong and increases its
/// uncertainty accordingly. A reading counts if at least a third of its scalars are outliers. For a DVL with four
/// beams, this means two outliers, since an error of the filter affects at least two beams; one outlier may be a single
/// bad beam.
inline constexpr std::uint64_t kReadingsBeforeDoubt = 5;
inline constexpr int kMaxReading = 8;

/// An instrument that corrects the filter. Lever arms are measured from the IMU, along the body axes.
class Aid {
 public:
  virtual ~Aid() = default;
  /// The number of values in a reading.
  virtual int width() const = 0;
  /// Models of the aid's biases, which become error states of the filter.
  virtual std::vector<BiasModel> biases() const { return {}; }
  /// Index of the first of the three errors that the aid observes; these are inflated when the filter doubts its
  /// estimate.
  virtual ErrorIndex seen() const = 0;
  /// Sets what the aid keeps in `state` besides its biases.
  virtual void begin(FilterState& /*state*/) const {}
  /// Advances errors that do not follow their BiasModel alone.
  virtual void age(FilterState& /*state*/, double /*dt_s*/) const {}
  /// Returns false for a reading that contradicts something which the state knows better than the instrument, so that
  /// it is left out whole, and never makes the filter doubt its estimate.
  virtual bool is_credible(const FilterState& /*state*/, const double* /*reading*/) const { return true; }
  /// Corrects `state` with a reading of shape (width(),), one scalar at a time.
  virtual void correct(FilterState& state, const double* reading) const = 0;
  /// Another aid has made the filter doubt its height, which may be this much higher [m].
  virtual void contradict(FilterState& /*state*/, double /*up_m*/) const {}
  /// Saves its parameters, or restores those in a saved state. Throws InvalidValue.
  virtual void exchange_parameters(StateArchive& archive) = 0;

  /// Positions of the aid's counts and biases in the state; set by NavigationFilter.
  int index = 0, first_bias = 0;

 protected:
  /// Applies one scalar, residual = h . error + white noise of `variance` + an error of `constant_variance` that does
  /// not change, in the Joseph form. Returns false for an outlier. However many readings there are, the variance of
  /// h . error does not fall below `constant_variance`.
  bool correct(FilterState& state, double residual, const ErrorVector& h, double variance,
               double constant_variance = 0) const;
  /// Increases the uncertainty of what the aid observes so that the residual becomes plausible.
  virtual void doubt(FilterState& state, double residual) const;
};

/// The errors of a Doppler log: white noise and a bias of each beam [m/s], the relative error of all velocities (speed
/// of sound), and a small rotation of the beams about each axis [rad].
struct DopplerErrors {
  double std = 0;
  BiasModel bias = {}, scale = {}, misalignment = {};
};
/// An aid whose reading is the velocities along beams, (n,) [m/s], with NaN for a lost beam. `beams_body` (n, 3): unit
/// vectors. Its biases: one for each beam, then scale and misalignment as far as they exist.
std::unique_ptr<Aid> doppler_aid(const Eigen::MatrixX3d& beams_body, const Eigen::Vector3d& lever_body_m,
                                 const DopplerErrors& errors);
/// The uncertainty of the water above a depth gauge, as standard deviations before the first reading; 0: none, ever.
/// See wave_pressure.h and water_above.h.
struct WaterErrors {
  double wave_std_m = 0;   ///< of the head of the waves' pressure; the filter then adapts it
  double level_std_m = 0;  ///< of the still surface about z = 0
  double column_std = 0;   ///< of the column's mean density, relative to that of the surface
};
/// An aid whose reading is the depth, (1,) [m, positive down], derived from a pressure by the density at the surface.
std::unique_ptr<Aid> depth_aid(const Eigen::Vector3d& lever_body_m, double std, const BiasModel& bias,
                               const WaterErrors& water);
/// An aid whose reading is the angle of `axis_body`, (1,) [rad], counter-clockwise from east. `north_rad`: the angle of
/// magnetic north. `iron_std`: standard deviation of the vehicle's own field along each body axis, as a fraction of the
/// earth's horizontal field.
std::unique_ptr<Aid> heading_aid(const Eigen::Vector3d& axis_body, double std, const BiasModel& bias, double iron_std,
                                 double north_rad);
/// The errors of an acoustic fix: white noise; the rounding of ranges to multiples of a step, which is white only while
/// the range changes from fix to fix; biases of the range, of its scale (speed of sound) and of both bearings; white
/// noise and a bias of the station's own place along east, north and up.
struct FixErrors {
  double range_std_m = 0, bearing_std_rad = 0;
  double range_step_m = 0;  ///< 0 if noise moves the ranges by more than a step
  double period_s = 1;
  BiasModel range_bias = {}, scale = {}, bearing_bias = {};
  double station_std_m = 0;
  BiasModel station_bias = {};
};
/// An aid whose reading is the position relative to a station along east, north and up, with errors along and across
/// the line of sight, then the station's place as it was meant to be, (6,) [m]. Its biases: range, scale, two bearings,
/// three of the station, as far as they exist. A fix whose height contradicts the depth is not credible: the sound came
/// by the bed or the surface, and its range and bearing are those of a mirrored station.
std::unique_ptr<Aid> acoustic_fix_aid(const Eigen::Vector3d& lever_body_m, const FixErrors& errors);
/// The errors of a satellite receiver: white noise, and biases along east and north, and up.
struct SatelliteErrors {
  double horizontal_std_m = 0, vertical_std_m = 0, velocity_std_m_s = 0;
  BiasModel horizontal_bias, vertical_bias;
};
/// An aid whose reading is the position [m] and the velocity [m/s] of an antenna along east, north and up, (6,).
std::unique_ptr<Aid> satellite_aid(const Eigen::Vector3d& lever_body_m, const SatelliteErrors& errors);
/// An aid whose reading is the orientation, a quaternion x, y, z, w that rotates body axes to world axes, (4,), with
/// errors in body axes.
std::unique_ptr<Aid> orientation_aid(double std, const BiasModel& bias);
/// An aid whose reading is the pose in which a dock holds the vehicle at rest: the position of the IMU [m] and the
/// orientation x, y, z, w, (7,). All its errors are constant: of the surveyed position [m] and attitude [rad], and of
/// the velocity [m/s], which jumps between two samples of the IMU when the dock lets go.
std::unique_ptr<Aid> dock_aid(double position_std, double attitude_std, double velocity_std);

}  // namespace uwsim
