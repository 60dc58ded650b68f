#include "uwsim/estimation/inertial.h"

#include <algorithm>
#include <cmath>

#include "uwsim/core/check.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

// Lower limits of the noise densities, which represent the error of integrating in steps. They also ensure that a
// filter with perfect instruments still accepts corrections.
constexpr double kLeastRateDensity = 2e-6;   // rad/sqrt(s)
constexpr double kLeastForceDensity = 2e-4;  // (m/s)/sqrt(s)
// The change in velocity that the IMU may not measure during a collision beyond its limits; assumed for an ROV that is
// stopped or thrown back.
constexpr double kShockVelocity_m_s = 1;
constexpr double kShockTurn_rad = 0.05;
// Noise densities used without IMU samples; assumed, comparable to the accelerations and turns of an ROV.
constexpr double kCoastForceDensity = 0.3;                 // (m/s)/sqrt(s)
const Eigen::Vector3d kCoastRateDensity(0.02, 0.02, 0.3);  // rad/sqrt(s); roll and pitch are stabilised by buoyancy

// Threshold for detecting a shock, such as hitting the ground: a second difference of the angular velocity that is
// larger than thrusters (assumed) and noise can cause. A second difference has sqrt(6) times the noise of one sample.
constexpr double kBlow_rad_s = 0.01;
constexpr double kBlowInNoise = 15;
// The rotation between the gyroscope's samples that goes unmeasured when the ground pushes the hull away. Assumed: if
// it is ignored, the NEES of the 9 errors after skids on the bed is 10.4 (uwsim validate estimation).
constexpr double kBlowTurn_rad = 1e-3;

constexpr double kEven = 1.5;  // two intervals count as equal up to this ratio

/// The variance that white noise of a sampled quantity adds to its integral over dt.
double integrated(double sample_std, double period_s, double least_density, double dt_s) {
  return std::max(sample_std * sample_std * period_s, least_density * least_density) * dt_s;
}

double seconds_between(std::uint64_t from_ns, std::uint64_t to_ns) {
  return 1e-9 * static_cast<double>(static_cast<std::int64_t>(to_ns - from_ns));
}

/// Computes P <- F P F^T for the blocks of position, velocity and attitude: rows first, then columns.
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

/// Sets the IMU's values for the time before the first sample: the angular velocity is that of the sample, and the
/// specific force is the same in world axes.
void guess_before(FilterState& state, const ImuSample& first) {
  const double ahead_s = seconds_between(state.time_ns, first.time_ns);
  state.sample.rate_rad_s = first.rate_rad_s;
  state.sample.force_m_s2 = rotation_by(ahead_s * (first.rate_rad_s - state.rate_bias_rad_s)) * first.force_m_s2;
}

/// Interpolates the IMU's values at `time_ns`, between the state's time and that of the next sample.
ImuSample between(const FilterState& state, const ImuSample& next, std::uint64_t time_ns) {
  if (time_ns == next.time_ns) return next;
  const double whole = seconds_between(state.time_ns, next.time_ns), passed = seconds_between(state.time_ns, time_ns);
  const double share = passed / whole;
  const Eigen::Vector3d rate = (1 - share) * state.sample.rate_rad_s + share * next.rate_rad_s;
  const Eigen::Vector3d turning = rate - state.rate_bias_rad_s;
  const Eigen::Vector3d before = rotation_by(-passed * turning) * state.sample.force_m_s2;
  const Eigen::Vector3d after = rotation_by((whole - passed) * turning) * next.force_m_s2;
  return {rate, (1 - share) * before + share * after, time_ns};
}

/// The rotation due to the curvature of the rate: the difference between the parabola through three samples and the
/// straight line through the last two, integrated over part of the interval. Zero if the samples are unevenly spaced,
/// such as after a gap, since slopes over short intervals are mostly noise.
Eigen::Vector3d bend(const LastSample& last, const Eigen::Vector3d& slope, double whole, double from, double to) {
  const auto integral = [whole](double t) { return t * t * (t / 3 - whole / 2); };
  if (last.slope_s == 0 || whole > kEven * last.slope_s || last.slope_s > kEven * whole) return Eigen::Vector3d::Zero();
  return (slope - last.rate_slope_rad_s2) / (whole + last.slope_s) * (integral(to) - integral(from));
}

/// Returns the rotation from the state's time to that of `now`, which is at or before the next sample, and records what
/// the next call needs.
Eigen::Vector3d turned(FilterState& state, const ImuSample& now, const ImuSample& next) {
  LastSample& last = state.sample;
  const double dt = seconds_between(state.time_ns, now.time_ns);
  const Eigen::Vector3d rate = last.rate_rad_s - state.rate_bias_rad_s,
                        rate_now = now.rate_rad_s - state.rate_bias_rad_s;
  Eigen::Vector3d turn = 0.5 * dt * (rate + rate_now) + dt * dt / 12 * rate.cross(rate_now);
  if (last.time_ns == LastSample::kNone) {
    last.guessed_s += dt;
  } else {
    const double whole = seconds_between(last.time_ns, next.time_ns),
                 from = seconds_between(last.time_ns, state.time_ns);
    const Eigen::Vector3d slope = (next.rate_rad_s - last.rate_rad_s) / (whole - from);
    turn += bend(last, slope, whole, from, from + dt);
    // Corrects guess_before(), which assumed a constant rate before the first sample: the rate probably changed then as
    // it does now.
    if (last.guessed_s > 0 && last.guessed_s <= kEven * whole) turn -= 0.5 * last.guessed_s * last.guessed_s * slope;
    last.guessed_s = 0;
    if (now.time_ns == next.time_ns) {
      last.rate_slope_rad_s2 = slope;
      last.slope_s = whole;
    }
  }
  if (now.time_ns == next.time_ns) last.time_ns = next.time_ns;
  last.rate_rad_s = now.rate_rad_s;
  return turn;
}

void grow(ErrorMatrix& p, int first, double variance) {
  for (int k = first; k < first + 3; ++k) p(k, k) += variance;
}

}  // namespace

/// A shock changes the angular velocity at some time between two samples. It is modelled as a step at a random time, so
/// the error is the change times dt / sqrt(12). During a shock, the samples carry little information, and the velocity
/// afterwards is unknown as well.
void Inertial::grow_by_shock(FilterState& state, double dt, const ImuSample& next) const {
  constexpr double kReached = 1 - 1e-9;
  const bool spins = next.rate_rad_s.norm() >= kReached * imu_.rate_limit;
  const bool is_shock = spins || next.force_m_s2.norm() >= kReached * imu_.force_limit;
  const Eigen::Vector3d change = next.rate_rad_s - state.sample.rate_rad_s;
  const double expected_s = state.sample.slope_s > 0 ? seconds_between(state.time_ns, next.time_ns) : 0;
  const double blow = (change - expected_s * state.sample.rate_slope_rad_s2).norm();
  if (is_shock || blow > std::max(kBlow_rad_s, kBlowInNoise * imu_.rate_std)) {
    const double step = change.norm() * dt / std::sqrt(12.0);
    grow(state.covariance, kAttitude, step * step + kBlowTurn_rad * kBlowTurn_rad);
  }
  if (!is_shock) return;
  grow(state.covariance, kVelocity, kShockVelocity_m_s * kShockVelocity_m_s);
  if (spins) grow(state.covariance, kAttitude, kShockTurn_rad * kShockTurn_rad);
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

std::vector<BiasModel> Inertial::matrix_biases() const {
  std::vector<BiasModel> all;
  for (const MatrixErrors& each : imu_.matrices) {
    for (int k = 0; each.exists() && k < 9; ++k) all.push_back({k % 4 == 0 ? each.diagonal_std : each.other_std});
  }
  return all;
}

MatrixEffects Inertial::effects(const ImuSample& sample) const {
  const Eigen::Matrix3d& turn = imu_.body_from_imu;
  MatrixEffects found = MatrixEffects::Zero(6, 27);
  int column = 0;
  for (std::size_t n = 0; n < imu_.matrices.size(); ++n) {
    const Eigen::Vector3d by = turn.transpose() * (n == 0 ? sample.rate_rad_s : sample.force_m_s2);
    for (int k = 0; k < 3 && imu_.matrices[n].exists(); ++k, column += 3) {
      found.block<3, 3>(n < 2 ? 3 : 0, column) = turn.col(k) * by.transpose();
    }
  }
  return found.leftCols(column);
}

void Inertial::advance(FilterState& state, std::uint64_t time_ns, const ImuSample& measured,
                       const std::vector<BiasModel>& aid_biases) const {
  const double dt = seconds_between(state.time_ns, time_ns);
  MatrixEffects by_element = effects(measured);
  const Eigen::Index elements = by_element.cols();
  const Eigen::Matrix<double, 6, 1> known = by_element * state.aid_bias.head(elements);
  const ImuSample next{measured.rate_rad_s - known.tail<3>(), measured.force_m_s2 - known.head<3>(), measured.time_ns};
  if (state.sample.time_ns == LastSample::kNone) guess_before(state, next);
  const ImuSample now = between(state, next, time_ns);
  grow_by_shock(state, dt, next);
  const Eigen::Matrix3d before = state.orientation.toRotationMatrix();
  const Eigen::Vector3d turn = turned(state, now, next);
  state.orientation = (state.orientation * rotation_by(turn)).normalized();
  const Eigen::Matrix3d after = state.orientation.toRotationMatrix();
  // A sample that is a mean applies to the middle of its averaging time, so the later sample has more weight.
  const double share = 0.5 * (1 + imu_.averaging_s / dt);
  const Eigen::Matrix3d turn_forces = share * after;
  const Eigen::Matrix3d turn_earlier = (1 - share) * before;
  const Eigen::Vector3d force_world = turn_earlier * (state.sample.force_m_s2 - state.force_bias_m_s2) +
                                      turn_forces * (now.force_m_s2 - state.force_bias_m_s2);
  const Eigen::Vector3d gain = dt * (force_world - Eigen::Vector3d(0, 0, gravity_m_s2_));
  state.position_m += dt * (state.velocity_m_s + 0.5 * gain);
  state.velocity_m_s += gain;
  state.sample.force_m_s2 = now.force_m_s2;
  state.time_ns = time_ns;
  ErrorMatrix& p = state.covariance;
  // At both ends of the interval, R [f]x e = [R f]x R e, where e is the attitude error at the start.
  transport(p, dt, -dt * cross_matrix(force_world) * before, -dt * (turn_earlier + turn_forces),
            rotation_by(-turn).toRotationMatrix());
  if (elements > 0) {  // the errors of the elements do not change, so that their part of F acts after the rest
    by_element.topRows<3>() = (-dt * (turn_earlier + turn_forces) * by_element.topRows<3>()).eval();
    by_element.bottomRows<3>() *= -dt;
    p.middleRows<6>(kVelocity) += by_element * p.middleRows(kAidBias, elements);
    p.middleCols<6>(kVelocity) += p.middleCols(kAidBias, elements) * by_element.transpose();
  }
  grow(p, kVelocity, integrated(imu_.force_std, imu_.period_s, kLeastForceDensity, dt));
  grow(p, kAttitude, integrated(imu_.rate_std, imu_.period_s, kLeastRateDensity, dt));
  age_biases(state, dt, aid_biases);
}

void Inertial::exchange_parameters(StateArchive& archive) {
  exchange_not_negative(archive, imu_.rate_std, imu_.force_std, imu_.period_s, imu_.averaging_s, gravity_m_s2_);
  for (MatrixErrors& each : imu_.matrices) exchange_not_negative(archive, each.diagonal_std, each.other_std);
  exchange_numbers(archive, imu_.body_from_imu);
  exchange_bias(archive, imu_.rate_bias, imu_.force_bias);
  exchange_any(archive, imu_.rate_limit);
  exchange_any(archive, imu_.force_limit);
  require(imu_.averaging_s <= imu_.period_s, "state.averaging_s", imu_.averaging_s, "must be at most the period");
}

void Inertial::coast(FilterState& state, std::uint64_t time_ns, const std::vector<BiasModel>& aid_biases) const {
  const double dt = seconds_between(state.time_ns, time_ns);
  state.position_m += dt * state.velocity_m_s;
  state.sample = {.rate_rad_s = state.rate_bias_rad_s};
  state.time_ns = time_ns;
  ErrorMatrix& p = state.covariance;
  transport(p, dt, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity());
  grow(p, kVelocity, kCoastForceDensity * kCoastForceDensity * dt);
  p.diagonal().segment<3>(kAttitude) += dt * kCoastRateDensity.cwiseAbs2();
  age_biases(state, dt, aid_biases);
}

}  // namespace uwsim
