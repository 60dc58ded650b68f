#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes p + R r - station, the position relative to the station, as one scalar along the line of sight and two
/// across it, with independent errors.
class AcousticFixAid final : public Aid {
 public:
  AcousticFixAid(const Eigen::Vector3d& lever, const Eigen::Vector3d& station, const FixErrors& errors)
      : lever_(lever), station_(station), errors_(errors) {}

  int width() const override { return 3; }
  ErrorIndex seen() const override { return kPosition; }

  bool is_credible(const FilterState& state, const double* reading) const override {
    if (!is_height_judged_) return true;
    const Eigen::Vector3d fix = Eigen::Vector3d::Map(reading);
    const double range = fix.norm(), off = std::abs(fix.z() - expected(state).z());
    const double known = state.covariance(kPosition + 2, kPosition + 2);
    const double measured = errors_.bearing_std_rad * errors_.bearing_std_rad * range * range;
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
    const Eigen::Vector3d sight = is_known ? expected(state).normalized() : (fix / range).eval();
    const Eigen::Vector3d across = sight.unitOrthogonal(), up = sight.cross(across);
    const double along = is_known ? range - expected(state).norm() : sight.dot(fix - expected(state));
    const double sideways = errors_.bearing_std_rad * range, rounding = rounding_std_m(state, sight);
    correct_along(state, along, sight, errors_.range_std_m, rounding);
    correct_along(state, across.dot(fix - expected(state)), across, sideways, 0);
    correct_along(state, up.dot(fix - expected(state)), up, sideways, 0);
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, lever_);
    exchange_numbers(archive, station_);
    exchange_not_negative(archive, errors_.range_std_m);
    exchange_not_negative(archive, errors_.bearing_std_rad);
    exchange_not_negative(archive, errors_.range_step_m);
    exchange_not_negative(archive, errors_.period_s);
    archive(is_height_judged_);
  }

 private:
  static constexpr double kKnown = 0.1;     // as a fraction of the range
  static constexpr double kMirrored = 0.1;  // height's error of a mirrored path, at least, as a fraction of the range

  Eigen::Vector3d expected(const FilterState& state) const {
    return state.position_m + state.orientation * lever_ - station_;
  }

  /// The standard deviation of the rounding's error if the range changes by less than half a step until the next fix.
  double rounding_std_m(const FilterState& state, const Eigen::Vector3d& sight) const {
    const bool rests = std::abs(sight.dot(state.velocity_m_s)) * errors_.period_s < 0.5 * errors_.range_step_m;
    return rests ? errors_.range_step_m / std::sqrt(12.0) : 0;
  }

  void correct_along(FilterState& state, double residual, const Eigen::Vector3d& axis, double white_std,
                     double constant_std) const {
    ErrorVector h = ErrorVector::Zero(state.errors());
    h.segment<3>(kPosition) = axis;
    h.segment<3>(kAttitude) = lever_.cross(state.orientation.conjugate() * axis);
    constexpr double kLeast = 1e-6;  // m2; so that an exact fix also has a gate
    Aid::correct(state, residual, h, std::max(white_std * white_std, kLeast), constant_std * constant_std);
  }

  Eigen::Vector3d lever_, station_;
  FixErrors errors_;
  bool is_height_judged_ = true;
};

}  // namespace

std::unique_ptr<Aid> acoustic_fix_aid(const Eigen::Vector3d& lever_body_m, const Eigen::Vector3d& station_world_m,
                                      const FixErrors& errors) {
  return std::make_unique<AcousticFixAid>(lever_body_m, station_world_m, errors);
}

}  // namespace uwsim
