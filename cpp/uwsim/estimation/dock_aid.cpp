#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes that a dock holds the vehicle: the dock's surveyed pose, and no velocity (a zero-velocity update, Groves
/// 2013, ch. 15.3).
class DockAid final : public Aid {
 public:
  DockAid(double position_std, double attitude_std, double velocity_std)
      : position_std_(position_std), attitude_std_(attitude_std), velocity_std_(velocity_std) {}

  int width() const override { return 7; }
  ErrorIndex seen() const override { return kPosition; }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Quaterniond held(Eigen::Vector4d::Map(reading + 3));
    for (int k = 0; k < 3; ++k) {
      correct_error(state, kVelocity + k, -state.velocity_m_s[k], velocity_std_);
      correct_error(state, kPosition + k, reading[k] - state.position_m[k], position_std_);
      const Eigen::AngleAxisd turn(state.orientation.conjugate() * held);
      const double angle = std::remainder(turn.angle(), 2 * EIGEN_PI) * turn.axis()[k];
      correct_error(state, kAttitude + k, angle, attitude_std_);
    }
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_not_negative(archive, position_std_, attitude_std_, velocity_std_);
  }

 private:
  void correct_error(FilterState& state, int error, double residual, double constant_std) const {
    ErrorVector h = ErrorVector::Zero(state.errors());
    h[error] = 1;
    Aid::correct(state, residual, h, 0, constant_std * constant_std);
  }

  double position_std_, attitude_std_, velocity_std_;
};

}  // namespace

std::unique_ptr<Aid> dock_aid(double position_std, double attitude_std, double velocity_std) {
  return std::make_unique<DockAid>(position_std, attitude_std, velocity_std);
}

}  // namespace uwsim
