#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes the orientation reported by an attitude filter, true orientation * Exp(bias + noise), as three scalars.
class OrientationAid final : public Aid {
 public:
  OrientationAid(double std, const BiasModel& bias) : variance_(std * std), bias_(bias) {}

  int width() const override { return 4; }
  std::vector<BiasModel> biases() const override { return {3, bias_}; }
  ErrorIndex seen() const override { return kAttitude; }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Quaterniond measured(Eigen::Vector4d::Map(reading));
    for (int k = 0; k < 3; ++k) {
      const Eigen::AngleAxisd turn(state.orientation.conjugate() * measured);
      const double residual = std::remainder(turn.angle(), 2 * EIGEN_PI) * turn.axis()[k];
      ErrorVector h = ErrorVector::Zero(state.errors());
      h[kAttitude + k] = 1;
      h[first_bias + k] = 1;
      Aid::correct(state, residual - state.aid_bias[first_bias - kAidBias + k], h, variance_);
    }
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_not_negative(archive, variance_);
    exchange_bias(archive, bias_);
  }

 private:
  double variance_;
  BiasModel bias_;
};

}  // namespace

std::unique_ptr<Aid> orientation_aid(double std, const BiasModel& bias) {
  return std::make_unique<OrientationAid>(std, bias);
}

}  // namespace uwsim
