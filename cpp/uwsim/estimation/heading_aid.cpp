#include <cmath>
#include <numbers>

#include "uwsim/estimation/aid.h"

namespace uwsim {
namespace {

/// The yaw of a compass's x axis. With the vehicle's own field (i_x, i_y), as a share of the earth's horizontal field,
/// and the angle a from the compass's x to magnetic north, yaw is measured too small by i_y cos a - i_x sin a (Groves
/// 2013, ch. 6.1): turning tells it from an error of the attitude.
class HeadingAid final : public Aid {
 public:
  HeadingAid(const Eigen::Vector3d& axis, double std, const BiasModel& bias, double iron_std, double north_rad)
      : axis_(axis), variance_(std * std), bias_(bias), iron_std_(iron_std), north_rad_(north_rad) {}

  int width() const override { return 1; }
  std::vector<BiasModel> biases() const override {
    const BiasModel iron{.turn_on_std = iron_std_};
    return {bias_, iron, iron};
  }
  ErrorIndex seen() const override { return kAttitude; }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Vector3d ahead = state.orientation * axis_;
    const double level = ahead.head<2>().squaredNorm();
    if (level < 1e-4) return;  // it points straight up or down
    // By the expected yaw, not the measured one, whose noise would be in `sees` as it is in the residual: readings at
    // one heading would then tell of a field that is not there.
    const double yaw = std::atan2(ahead.y(), ahead.x()), north = north_rad_ - yaw;
    const Eigen::Vector3d sees(1, std::sin(north), -std::cos(north));
    const double expected = yaw + sees.dot(state.aid_bias.segment<3>(first_bias - kAidBias));
    ErrorVector h = ErrorVector::Zero(state.errors());
    // d yaw = (a_x da_y - a_y da_x) / level, da = -R [axis]x error.
    const Eigen::Vector3d turned = state.orientation.conjugate() * Eigen::Vector3d(-ahead.y(), ahead.x(), 0);
    h.segment<3>(kAttitude) = axis_.cross(turned) / level;
    h.segment<3>(first_bias) = sees;
    Aid::correct(state, std::remainder(reading[0] - expected, 2 * std::numbers::pi), h, variance_);
  }

 private:
  Eigen::Vector3d axis_;
  double variance_;
  BiasModel bias_;
  double iron_std_, north_rad_;
};

}  // namespace

std::unique_ptr<Aid> heading_aid(const Eigen::Vector3d& axis_body, double std, const BiasModel& bias, double iron_std,
                                 double north_rad) {
  return std::make_unique<HeadingAid>(axis_body, std, bias, iron_std, north_rad);
}

}  // namespace uwsim
