#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/figures.h"

namespace uwsim {
namespace {

/// Observes p + R r - station, the position relative to the station, as one scalar along the line of sight and two
/// across it, with independent errors.
class AcousticFixAid final : public Aid {
 public:
  AcousticFixAid(const Eigen::Vector3d& lever, const Eigen::Vector3d& station, double range_std, double bearing_std)
      : lever_(lever), station_(station), range_std_(range_std), bearing_std_(bearing_std) {}

  int width() const override { return 3; }
  ErrorIndex seen() const override { return kPosition; }

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
    const double sideways = bearing_std_ * range;
    correct_along(state, along, sight, range_std_ * range_std_);
    correct_along(state, across.dot(fix - expected(state)), across, sideways * sideways);
    correct_along(state, up.dot(fix - expected(state)), up, sideways * sideways);
  }

  void exchange_figures(StateArchive& archive) override {
    exchange_numbers(archive, lever_);
    exchange_numbers(archive, station_);
    exchange_not_negative(archive, range_std_);
    exchange_not_negative(archive, bearing_std_);
  }

 private:
  static constexpr double kKnown = 0.1;  // as a fraction of the range

  Eigen::Vector3d expected(const FilterState& state) const {
    return state.position_m + state.orientation * lever_ - station_;
  }

  void correct_along(FilterState& state, double residual, const Eigen::Vector3d& axis, double variance) const {
    ErrorVector h = ErrorVector::Zero(state.errors());
    h.segment<3>(kPosition) = axis;
    h.segment<3>(kAttitude) = lever_.cross(state.orientation.conjugate() * axis);
    constexpr double kLeast = 1e-6;  // m2; so that an exact fix also has a gate
    Aid::correct(state, residual, h, std::max(variance, kLeast));
  }

  Eigen::Vector3d lever_, station_;
  double range_std_, bearing_std_;
};

}  // namespace

std::unique_ptr<Aid> acoustic_fix_aid(const Eigen::Vector3d& lever_body_m, const Eigen::Vector3d& station_world_m,
                                      double range_std, double bearing_std) {
  return std::make_unique<AcousticFixAid>(lever_body_m, station_world_m, range_std, bearing_std);
}

}  // namespace uwsim
