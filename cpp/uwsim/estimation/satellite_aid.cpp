#include <algorithm>
#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes the position of the antenna, p + R r + bias, and its velocity, v + R (omega x r), as six scalars.
class SatelliteAid final : public Aid {
 public:
  SatelliteAid(const Eigen::Vector3d& lever, const SatelliteErrors& errors) : lever_(lever), errors_(errors) {}

  int width() const override { return 6; }
  std::vector<BiasModel> biases() const override {
    return {errors_.horizontal_bias, errors_.horizontal_bias, errors_.vertical_bias};
  }
  ErrorIndex seen() const override { return kPosition; }

  void correct(FilterState& state, const double* reading) const override {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d axis_body = state.orientation.conjugate() * Eigen::Vector3d::Unit(k);
      const double std_m = k < 2 ? errors_.horizontal_std_m : errors_.vertical_std_m;
      ErrorVector h = ErrorVector::Zero(state.errors());
      h[kPosition + k] = h[first_bias + k] = 1;
      h.segment<3>(kAttitude) = lever_.cross(axis_body);
      const double expected_m = state.position_m[k] + axis_body.dot(lever_) + state.aid_bias[first_bias - kAidBias + k];
      Aid::correct(state, reading[k] - expected_m, h, std_m * std_m);
    }
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d axis_body = state.orientation.conjugate() * Eigen::Vector3d::Unit(k),
                            swing_m_s = state.rate_rad_s().cross(lever_);
      ErrorVector h = ErrorVector::Zero(state.errors());
      h[kVelocity + k] = 1;
      h.segment<3>(kAttitude) = swing_m_s.cross(axis_body);
      h.segment<3>(kRateBias) = axis_body.cross(lever_);
      Aid::correct(state, reading[3 + k] - state.velocity_m_s[k] - axis_body.dot(swing_m_s), h,
                   errors_.velocity_std_m_s * errors_.velocity_std_m_s);
    }
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, lever_);
    exchange_not_negative(archive, errors_.horizontal_std_m, errors_.vertical_std_m, errors_.velocity_std_m_s);
    exchange_bias(archive, errors_.horizontal_bias, errors_.vertical_bias);
  }

 private:
  Eigen::Vector3d lever_;
  SatelliteErrors errors_;
};

}  // namespace

std::unique_ptr<Aid> satellite_aid(const Eigen::Vector3d& lever_body_m, const SatelliteErrors& errors) {
  return std::make_unique<SatelliteAid>(lever_body_m, errors);
}

}  // namespace uwsim
