#pragma once

#include <array>
#include <limits>
#include <vector>

#include "uwsim/core/state_archive.h"
#include "uwsim/estimation/filter_state.h"

namespace uwsim {

/// The errors of a constant 3 x 3 matrix N in the IMU's axes, by which one of its vectors takes up another: x + N y is
/// measured in place of x (Groves 2013, eq. 4.16 and 4.17). y is the measured one, so that this holds for large N, too.
struct MatrixErrors {
  double diagonal_std = 0, other_std = 0;  ///< of an element
  bool exists() const { return diagonal_std + other_std > 0; }
};

/// The errors of an inertial measurement unit, per axis.
struct ImuErrors {
  double rate_std = 0;   ///< [rad/s] white noise of a sample, including quantisation
  double force_std = 0;  ///< [m/s2]
  double period_s = 0.005;
  /// A sample's specific force is the mean over this time before the sample; 0 if it is an instantaneous value
  double averaging_s = 0;
  BiasModel rate_bias, force_bias;
  /// Errors of the rate by the rate [1], of the rate by the force [rad s/m], of the force by the force [1].
  std::array<MatrixErrors, 3> matrices = {};
  Eigen::Matrix3d body_from_imu = Eigen::Matrix3d::Identity();
  /// The largest magnitude that an axis can measure [rad/s], [m/s2]; a sample at this limit understates a shock.
  double rate_limit = std::numeric_limits<double>::infinity();
  double force_limit = std::numeric_limits<double>::infinity();
};

/// A sample of the IMU, in body axes at its time.
struct ImuSample {
  Eigen::Vector3d rate_rad_s, force_m_s2;  ///< angular velocity, specific force
  std::uint64_t time_ns;
};

/// How the force (upper rows) and the rate (lower rows) of a sample change with the elements of the IMU's matrices.
using MatrixEffects = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 27>;

/// Strapdown navigation and the growth of its errors (Sola 2017, sections 5.3 and 5.4, local attitude error). Each
/// sample's force is rotated by the attitude at the sample's time. Between samples, the force is interpolated linearly
/// in world axes, and the angular velocity by the parabola through the newest three samples, with the coning correction
/// dt^2/12 w0 x w1 for rotating axes (Savage 1998, "Strapdown Inertial Navigation Integration Algorithm Design, Part
/// 1", J. Guidance, Control and Dynamics 21:19, section on coning; Groves 2013, ch. 5.5). The errors are of third order
/// in the rotation per step, so the method is valid if a step rotates by much less than 1 rad. The earth's rotation is
/// neglected.
class Inertial {
 public:
  Inertial(const ImuErrors& imu, double gravity_m_s2) : imu_(imu), gravity_m_s2_(gravity_m_s2) {}

  /// Advances the state to `time_ns`, at or before the next sample's time. `aid_biases`: one for each error from
  /// kAidBias on.
  void advance(FilterState& state, std::uint64_t time_ns, const ImuSample& measured,
               const std::vector<BiasModel>& aid_biases) const;
  /// Advances the state without a sample, assuming motion in a straight line. The covariance grows fast enough to cover
  /// manoeuvres.
  void coast(FilterState& state, std::uint64_t time_ns, const std::vector<BiasModel>& aid_biases) const;

  /// Saves or restores the parameters passed to the constructor. Throws InvalidValue.
  void exchange_parameters(StateArchive& archive);

  const ImuErrors& errors() const { return imu_; }
  /// Models of the matrices' elements, row by row, of those that exist: the first errors from kAidBias on.
  std::vector<BiasModel> matrix_biases() const;
  double gravity_m_s2() const { return gravity_m_s2_; }

 private:
  MatrixEffects effects(const ImuSample& sample) const;
  void grow_by_shock(FilterState& state, double dt_s, const ImuSample& next) const;
  void age_biases(FilterState& state, double dt_s, const std::vector<BiasModel>& aid_biases) const;

  ImuErrors imu_;
  double gravity_m_s2_;
};

}  // namespace uwsim
