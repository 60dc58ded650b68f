#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/figures.h"

namespace uwsim {
namespace {

/// Observes the depth, -(p + R r)_z + bias.
class DepthAid final : public Aid {
 public:
  DepthAid(const Eigen::Vector3d& lever, double std, const BiasModel& bias)
      : lever_(lever), variance_(std * std), bias_(bias) {}

  int width() const override { return 1; }
  std::vector<BiasModel> biases() const override { return {bias_}; }
  ErrorIndex seen() const override { return kPosition; }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Vector3d up_body = state.orientation.conjugate() * Eigen::Vector3d::UnitZ();
    const double expected = -state.position_m.z() - up_body.dot(lever_) + state.aid_bias[first_bias - kAidBias];
    ErrorVector h = ErrorVector::Zero(state.errors());
    h[kPosition + 2] = -1;
    h.segment<3>(kAttitude) = up_body.cross(lever_);
    h[first_bias] = 1;
    Aid::correct(state, reading[0] - expected, h, variance_);
  }

  void exchange_figures(StateArchive& archive) override {
    exchange_numbers(archive, lever_);
    exchange_not_negative(archive, variance_);
    exchange_bias(archive, bias_);
  }

 private:
  Eigen::Vector3d lever_;
  double variance_;
  BiasModel bias_;
};

}  // namespace

std::unique_ptr<Aid> depth_aid(const Eigen::Vector3d& lever_body_m, double std, const BiasModel& bias) {
  return std::make_unique<DepthAid>(lever_body_m, std, bias);
}

}  // namespace uwsim
