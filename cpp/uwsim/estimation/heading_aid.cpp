#include <cmath>
#include <numbers>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes the yaw of a compass's x axis. Let i be the vehicle's own field, in body axes, as a fraction of the earth's
/// horizontal field, and n the direction of magnetic north. The measured yaw is then too small by (n x R i)_z (Groves
/// 2013, ch. 6.1). If the vehicle stays level, turning distinguishes this effect from an attitude error. The upward
/// component of the field matters only when the vehicle rolls or pitches.
class HeadingAid final : public Aid {
 public:
  HeadingAid(const Eigen::Vector3d& axis, double std, const BiasModel& bias, double iron_std, double north_rad)
      : axis_(axis), variance_(std * std), bias_(bias), iron_std_(iron_std), north_rad_(north_rad) {}

  int width() const override { return 1; }
  std::vector<BiasModel> biases() const override {
    const BiasModel iron{.turn_on_std = iron_std_};
    return {bias_, iron, iron, iron};
  }
  ErrorIndex seen() const override { return kAttitude; }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Vector3d ahead = state.orientation * axis_;
    const double level = ahead.head<2>().squaredNorm();
    if (level < 1e-4 || !is_straight(state, ahead.z(), level)) return;
    // Use the expected yaw. With the measured yaw, the same noise would appear in `sees` and in the residual, and
    // readings at a single heading would then seem to reveal a field that does not exist.
    const double yaw = std::atan2(ahead.y(), ahead.x());
    const Eigen::Vector3d east_of_north(std::sin(north_rad_), -std::cos(north_rad_), 0);
    Eigen::Vector4d sees;
    sees << 1, state.orientation.conjugate() * east_of_north;
    const double expected = yaw + sees.dot(state.aid_bias.segment<4>(first_bias - kAidBias));
    ErrorVector h = ErrorVector::Zero(state.errors());
    // d yaw = (a_x da_y - a_y da_x) / level, da = -R [axis]x error.
    const Eigen::Vector3d turned = state.orientation.conjugate() * Eigen::Vector3d(-ahead.y(), ahead.x(), 0);
    h.segment<3>(kAttitude) = axis_.cross(turned) / level;
    h.segment<4>(first_bias) = sees;
    Aid::correct(state, std::remainder(reading[0] - expected, 2 * std::numbers::pi), h, variance_);
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, axis_);
    exchange_not_negative(archive, variance_, iron_std_);
    exchange_bias(archive, bias_);
    archive(north_rad_);
  }

 private:
  // The largest error of the linearised yaw, as a fraction of the yaw's own error.
  static constexpr double kBent = 0.1;

  /// Returns true if the yaw is linear in the error of the attitude. Where the axis points steeply up or down, an error
  /// e of its elevation changes the yaw's derivative by the fraction e tan(elevation). Readings there would make the
  /// filter sure of a wrong attitude.
  bool is_straight(const FilterState& state, double up, double level) const {
    const Eigen::Vector3d up_body = state.orientation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d pitching = axis_.cross(up_body) / std::sqrt(level);  // the elevation's derivative
    const double variance = pitching.dot(state.covariance.block<3, 3>(kAttitude, kAttitude) * pitching);
    return variance * up * up <= kBent * kBent * level;
  }

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
