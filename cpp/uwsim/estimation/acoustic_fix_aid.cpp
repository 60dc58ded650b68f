#include <array>
#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes p + R r - station, the position relative to the station, as one scalar along the line of sight and two
/// across it, with independent errors.
class AcousticFixAid final : public Aid {
 public:
  AcousticFixAid(const Eigen::Vector3d& lever, const FixErrors& errors) : lever_(lever), errors_(errors) {}

  int width() const override { return 6; }
  std::vector<BiasModel> biases() const override {
    std::vector<BiasModel> all;
    if (errors_.range_bias.exists()) all.push_back(errors_.range_bias);
    if (errors_.scale.exists()) all.push_back(errors_.scale);
    if (errors_.bearing_bias.exists()) all.insert(all.end(), 2, errors_.bearing_bias);
    if (errors_.station_bias.exists()) all.insert(all.end(), 3, errors_.station_bias);
    return all;
  }
  ErrorIndex seen() const override { return kPosition; }

  bool is_credible(const FilterState& state, const double* reading) const override {
    if (!is_height_judged_) return true;
    const Eigen::Vector3d fix = Eigen::Vector3d::Map(reading);
    const double range = fix.norm(), off = std::abs(fix.z() - expected(state, reading).z());
    const double known = state.covariance(kPosition + 2, kPosition + 2);
    const double bearing = errors_.bearing_std_rad * errors_.bearing_std_rad + errors_.bearing_bias.variance();
    const double measured = bearing * range * range + station_variance() + errors_.station_bias.variance();
    return known > measured || off < kMirrored * range || off * off < kGate * kGate * (known + measured);
  }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Vector3d fix = Eigen::Vector3d::Map(reading);
    const double range = fix.norm();
    if (!(range > 1e-6)) return;
    // If the position is known well, use axes along and across the expected line of sight. Along the measured line of
    // sight, the bearing error would affect the range: the vehicle is at R cos error, which is R (1 - cos error) less
    // than R.
    const double position_variance = state.covariance.diagonal().segment<3>(kPosition).sum();
    const bool is_known = position_variance < kKnown * kKnown * range * range;
    const Eigen::Vector3d seen = expected(state, reading), sight = (is_known ? seen : fix).normalized();
    const Eigen::Vector3d across = across_of(sight), up = sight.cross(across);
    const double along = is_known ? range - seen.norm() : sight.dot(fix - seen);
    const double sideways = errors_.bearing_std_rad * range, rounding = rounding_std_m(state, sight);
    correct_along(state, along, sight, errors_.range_std_m, rounding, {1, range, 0, 0});
    correct_along(state, across.dot(fix - expected(state, reading)), across, sideways, 0, {0, 0, range, 0});
    correct_along(state, up.dot(fix - expected(state, reading)), up, sideways, 0, {0, 0, 0, range});
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, lever_);
    exchange_not_negative(archive, errors_.range_std_m, errors_.bearing_std_rad, errors_.range_step_m, errors_.period_s,
                          errors_.station_std_m);
    exchange_bias(archive, errors_.range_bias, errors_.scale, errors_.bearing_bias, errors_.station_bias);
    archive(is_height_judged_);
  }

 private:
  static constexpr double kKnown = 0.1;     // as a fraction of the range
  static constexpr double kMirrored = 0.1;  // height's error of a mirrored path, at least, as a fraction of the range

  /// The level axis across a line of sight.
  static Eigen::Vector3d across_of(const Eigen::Vector3d& sight) {
    const Eigen::Vector3d level(-sight.y(), sight.x(), 0);
    return level.norm() > 1e-9 ? level.normalized() : Eigen::Vector3d::UnitY().eval();
  }

  double station_variance() const { return errors_.station_std_m * errors_.station_std_m; }

  /// The position relative to where the station takes itself to be.
  Eigen::Vector3d expected(const FilterState& state, const double* reading) const {
    return state.position_m + state.orientation * lever_ - Eigen::Vector3d::Map(reading + 3);
  }

  /// The standard deviation of the rounding's error if the range changes by less than half a step until the next fix.
  double rounding_std_m(const FilterState& state, const Eigen::Vector3d& sight) const {
    const bool rests = std::abs(sight.dot(state.velocity_m_s)) * errors_.period_s < 0.5 * errors_.range_step_m;
    return rests ? errors_.range_step_m / std::sqrt(12.0) : 0;
  }

  /// `weights`: of the biases of range, scale and both bearings.
  void correct_along(FilterState& state, double residual, const Eigen::Vector3d& axis, double white_std,
                     double constant_std, const std::array<double, 4>& weights) const {
    ErrorVector h = ErrorVector::Zero(state.errors());
    h.segment<3>(kPosition) = axis;
    h.segment<3>(kAttitude) = lever_.cross(state.orientation.conjugate() * axis);
    int bias = first_bias;
    const BiasModel* models[] = {&errors_.range_bias, &errors_.scale, &errors_.bearing_bias, &errors_.bearing_bias};
    for (std::size_t k = 0; k < weights.size(); ++k) {
      if (!models[k]->exists()) continue;
      residual -= weights[k] * state.aid_bias[bias - kAidBias];
      h[bias++] = weights[k];
    }
    if (errors_.station_bias.exists()) {
      h.segment<3>(bias) = axis;
      residual -= axis.dot(state.aid_bias.segment<3>(bias - kAidBias));
    }
    constexpr double kLeast = 1e-6;  // m2; so that an exact fix also has a gate
    Aid::correct(state, residual, h, std::max(white_std * white_std + station_variance(), kLeast),
                 constant_std * constant_std);
  }

  Eigen::Vector3d lever_;
  FixErrors errors_;
  bool is_height_judged_ = true;
};

}  // namespace

std::unique_ptr<Aid> acoustic_fix_aid(const Eigen::Vector3d& lever_body_m, const FixErrors& errors) {
  return std::make_unique<AcousticFixAid>(lever_body_m, errors);
}

}  // namespace uwsim
