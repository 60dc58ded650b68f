#include <cmath>
#include <utility>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes each beam's velocity separately, b . (R^T v + omega x r) + bias, so that even one or two good beams help.
class DopplerAid final : public Aid {
 public:
  DopplerAid(Eigen::MatrixX3d beams, const Eigen::Vector3d& lever, double std, const BiasModel& bias)
      : beams_(std::move(beams)), lever_(lever), variance_(std * std), bias_(bias) {}

  int width() const override { return static_cast<int>(beams_.rows()); }
  std::vector<BiasModel> biases() const override { return {static_cast<std::size_t>(width()), bias_}; }
  ErrorIndex seen() const override { return kVelocity; }

  void correct(FilterState& state, const double* reading) const override {
    for (int k = 0; k < width(); ++k) {
      if (std::isfinite(reading[k])) correct_beam(state, k, reading[k]);
    }
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, beams_);
    exchange_numbers(archive, lever_);
    exchange_not_negative(archive, variance_);
    exchange_bias(archive, bias_);
  }

 private:
  void correct_beam(FilterState& state, int k, double speed_m_s) const {
    const Eigen::Vector3d beam = beams_.row(k).transpose();
    const Eigen::Vector3d velocity_body = state.orientation.conjugate() * state.velocity_m_s;
    const double expected =
        beam.dot(velocity_body + state.rate_rad_s().cross(lever_)) + state.aid_bias[first_bias - kAidBias + k];
    ErrorVector h = ErrorVector::Zero(state.errors());
    h.segment<3>(kVelocity) = state.orientation * beam;
    h.segment<3>(kAttitude) = beam.cross(velocity_body);
    h.segment<3>(kRateBias) = beam.cross(lever_);
    h[first_bias + k] = 1;
    Aid::correct(state, speed_m_s - expected, h, variance_);
  }

  Eigen::MatrixX3d beams_;
  Eigen::Vector3d lever_;
  double variance_;
  BiasModel bias_;
};

}  // namespace

std::unique_ptr<Aid> doppler_aid(const Eigen::MatrixX3d& beams_body, const Eigen::Vector3d& lever_body_m, double std,
                                 const BiasModel& bias) {
  return std::make_unique<DopplerAid>(beams_body, lever_body_m, std, bias);
}

}  // namespace uwsim
