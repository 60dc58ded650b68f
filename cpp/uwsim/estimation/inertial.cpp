#include "uwsim/estimation/inertial.h"

#include <algorithm>
#include <cmath>

namespace uwsim {
namespace {

// The error of integration by steps, so that even a filter of perfect instruments stays open to fixes.
constexpr double kLeastRateDensity = 2e-6;   // rad/sqrt(s)
constexpr double kLeastForceDensity = 2e-4;  // (m/s)/sqrt(s)
// A collision that exceeds the IMU's limits: what it may hide, assumed, as of an ROV that is stopped or thrown back.
constexpr double kShockVelocity_m_s = 1;
constexpr double kShockTurn_rad = 0.05;
// A vehicle without an IMU: assumed, of the order of an ROV's manoeuvres.
constexpr double kCoastForceDensity = 0.3;                 // (m/s)/sqrt(s)
const Eigen::Vector3d kCoastRateDensity(0.02, 0.02, 0.3);  // rad/sqrt(s); roll and pitch are righted

/// The variance that white noise of a sampled quantity adds to its integral over dt.
double integrated(double sample_std, double period_s, double least_density, double dt_s) {
  return std::max(sample_std * sample_std * period_s, least_density * least_density) * dt_s;
}

double seconds_between(std::uint64_t from_ns, std::uint64_t to_ns) {
  return 1e-9 * static_cast<double>(static_cast<std::int64_t>(to_ns - from_ns));
}

/// P <- F P F^T for the blocks of position, velocity and attitude: rows first, then columns.
void transport(ErrorMatrix& p, double dt, const Eigen::Matrix3d& velocity_from_attitude,
               const Eigen::Matrix3d& velocity_from_force, const Eigen::Matrix3d& attitude_from_attitude) {
  p.middleRows<3>(kPosition) += dt * p.middleRows<3>(kVelocity);
  p.middleRows<3>(kVelocity).noalias() += velocity_from_attitude * p.middleRows<3>(kAttitude);
  p.middleRows<3>(kVelocity).noalias() += velocity_from_force * p.middleRows<3>(kForceBias);
  p.middleRows<3>(kAttitude) = (attitude_from_attitude * p.middleRows<3>(kAttitude)).eval();
  p.middleRows<3>(kAttitude) -= dt * p.middleRows<3>(kRateBias);
  p.middleCols<3>(kPosition) += dt * p.middleCols<3>(kVelocity);
  p.middleCols<3>(kVelocity).noalias() += p.middleCols<3>(kAttitude) * velocity_from_attitude.transpose();
  p.middleCols<3>(kVelocity).noalias() += p.middleCols<3>(kForceBias) * velocity_from_force.transpose();
  p.middleCols<3>(kAttitude) = (p.middleCols<3>(kAttitude) * attitude_from_attitude.transpose()).eval();
  p.middleCols<3>(kAttitude) -= dt * p.middleCols<3>(kRateBias);
}

void grow(ErrorMatrix& p, int first, double variance) {
  for (int k = first; k < first + 3; ++k) p(k, k) += variance;
}

}  // namespace

/// Within a shock the samples say little: the velocity that is left is not known, and the angular velocity changed at
/// some time between two samples, which as a step at a random time errs by its change times dt / sqrt(12).
void Inertial::grow_by_shock(FilterState& state, double dt, const ImuSample& sample) const {
  constexpr double kReached = 1 - 1e-9;
  const bool spins = sample.rate_rad_s.norm() >= kReached * imu_.rate_limit;
  if (!spins && sample.force_m_s2.norm() < kReached * imu_.force_limit) return;
  const double step = (sample.rate_rad_s - state.measured_rate_rad_s).norm() * dt / std::sqrt(12.0);
  grow(state.covariance, kVelocity, kShockVelocity_m_s * kShockVelocity_m_s);
  grow(state.covariance, kAttitude, step * step + (spins ? kShockTurn_rad * kShockTurn_rad : 0));
}

void Inertial::age_biases(FilterState& state, double dt, const std::vector<BiasModel>& aid_biases) const {
  ErrorMatrix& p = state.covariance;
  const auto age = [&](int k, const BiasModel& bias, double& value) {
    if (const double kept = bias.decay(dt); kept < 1) {
      value *= kept;
      p.row(k) *= kept;
      p.col(k) *= kept;
    }
    p(k, k) += bias.growth(dt);
  };
  for (int k = 0; k < 3; ++k) {
    age(kRateBias + k, imu_.rate_bias, state.rate_bias_rad_s[k]);
    age(kForceBias + k, imu_.force_bias, state.force_bias_m_s2[k]);
  }
  for (int k = kAidBias; k < state.errors(); ++k) {
    age(k, aid_biases[static_cast<std::size_t>(k - kAidBias)], state.aid_bias[k - kAidBias]);
  }
}

void Inertial::advance(FilterState& state, std::uint64_t time_ns, const ImuSample& sample,
                       const std::vector<BiasModel>& aid_biases) const {
  const double dt = seconds_between(state.time_ns, time_ns);
  const Eigen::Vector3d turn =
      dt * (0.5 * (state.measured_rate_rad_s + sample.rate_rad_s) - state.rate_bias_rad_s);  // mean of both ends
  const Eigen::Vector3d force = sample.force_m_s2 - state.force_bias_m_s2;
  const Eigen::Matrix3d midway = (state.orientation * rotation_by(0.5 * turn)).toRotationMatrix();
  const Eigen::Vector3d gain = dt * (midway * force - Eigen::Vector3d(0, 0, gravity_m_s2_));
  state.position_m += dt * (state.velocity_m_s + 0.5 * gain);
  state.velocity_m_s += gain;
  state.orientation = (state.orientation * rotation_by(turn)).normalized();
  grow_by_shock(state, dt, sample);
  state.measured_rate_rad_s = sample.rate_rad_s;
  state.time_ns = time_ns;
  ErrorMatrix& p = state.covariance;
  transport(p, dt, -dt * midway * cross_matrix(force), -dt * midway, rotation_by(-turn).toRotationMatrix());
  grow(p, kVelocity, integrated(imu_.force_std, imu_.period_s, kLeastForceDensity, dt));
  grow(p, kAttitude, integrated(imu_.rate_std, imu_.period_s, kLeastRateDensity, dt));
  age_biases(state, dt, aid_biases);
}

void Inertial::coast(FilterState& state, std::uint64_t time_ns, const std::vector<BiasModel>& aid_biases) const {
  const double dt = seconds_between(state.time_ns, time_ns);
  state.position_m += dt * state.velocity_m_s;
  state.measured_rate_rad_s = state.rate_bias_rad_s;
  state.time_ns = time_ns;
  ErrorMatrix& p = state.covariance;
  transport(p, dt, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity());
  grow(p, kVelocity, kCoastForceDensity * kCoastForceDensity * dt);
  p.diagonal().segment<3>(kAttitude) += dt * kCoastRateDensity.cwiseAbs2();
  age_biases(state, dt, aid_biases);
}

}  // namespace uwsim
