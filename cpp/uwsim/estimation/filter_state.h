#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace uwsim {

/// The order of the errors: position, velocity, attitude, gyroscope bias, accelerometer bias, then the elements of the
/// IMU's error matrices and the biases of aids.
enum ErrorIndex : int { kPosition = 0, kVelocity = 3, kAttitude = 6, kRateBias = 9, kForceBias = 12, kAidBias = 15 };
inline constexpr int kMaxErrors = 72;
inline constexpr int kMaxAids = 8;

using ErrorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxErrors, 1>;
using ErrorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxErrors, kMaxErrors>;

/// The model of one channel's bias, in the channel's unit u: the sum of a constant drawn at the start, a first-order
/// Gauss-Markov process with standard deviation `drift_std` and correlation time `drift_time_s`, and a random walk.
struct BiasModel {
  double turn_on_std = 0;   ///< [u]
  double drift_std = 0;     ///< [u]
  double drift_time_s = 0;  ///< 0: no drift
  double walk = 0;          ///< [u/sqrt(s)]
  bool of_water = false;    ///< not an instrument's: a restart of the filter keeps it

  /// True if there is such a bias at all.
  bool exists() const { return variance() > 0 || walk > 0; }
  double variance() const { return turn_on_std * turn_on_std + drift_std * drift_std; }
  /// The fraction of the bias that remains after dt. If there is a constant or a random walk as well as a drift, a
  /// single state represents both: the drift is treated as a random walk, which is accurate over times that are short
  /// compared with drift_time_s.
  double decay(double dt_s) const;
  /// The increase of the variance over dt [u2].
  double growth(double dt_s) const;
};

/// The numbers of an aid's scalars that were accepted and rejected, and of its latest consecutive readings with
/// outliers.
struct AidCounts {
  std::uint64_t accepted = 0, rejected = 0, in_a_row = 0;
  /// The variances of the aid's coloured noise and of the surface above it, as the aid estimates them; 0 without
  double noise_variance = 0, level_variance = 0;
};

/// The IMU's values at the state's time, interpolated between two samples, in the body axes at that time, without the
/// errors that its matrices explain. Biases are not removed.
struct LastSample {
  Eigen::Vector3d rate_rad_s = Eigen::Vector3d::Zero(), force_m_s2 = Eigen::Vector3d::Zero();
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::uint64_t time_ns = kNone;  ///< time of the newest sample that the state has reached since it started or coasted
  /// The change of the rate over the interval before that sample, and the interval's length; 0 if unknown.
  Eigen::Vector3d rate_slope_rad_s2 = Eigen::Vector3d::Zero();
  double slope_s = 0;
  double guessed_s = 0;  ///< how long before the first sample its rate was assumed to apply
};

/// The state of an error-state Kalman filter (Sola 2017, "Quaternion kinematics for the error-state Kalman filter"):
/// the motion of the IMU's centre, and the covariance of its errors. World ENU; REP 103 body axes. The attitude error
/// is local: true attitude = orientation * Exp(error).
struct FilterState {
  std::uint64_t time_ns = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< world axes
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate_bias_rad_s = Eigen::Vector3d::Zero(), force_bias_m_s2 = Eigen::Vector3d::Zero();
  ErrorVector aid_bias;  ///< at index (error index - kAidBias)
  ErrorMatrix covariance;
  LastSample sample;
  std::array<AidCounts, kMaxAids> counts;
  /// How often an aid made the filter doubt its estimate, and when it last did
  std::uint64_t doubts = 0, doubted_ns = 0;
  std::uint64_t restarted_ns = 0;  ///< time of the last restart
  double doubted_up_m = 0;  ///< how much higher the last doubt would have the vehicle; 0 of one that observes no height

  int errors() const { return static_cast<int>(covariance.rows()); }
  Eigen::Vector3d rate_rad_s() const { return sample.rate_rad_s - rate_bias_rad_s; }
  /// Adds the estimated error to the state.
  void add(const ErrorVector& error);
};

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);
/// The rotation by a vector [rad].
Eigen::Quaterniond rotation_by(const Eigen::Vector3d& angle_rad);

}  // namespace uwsim
