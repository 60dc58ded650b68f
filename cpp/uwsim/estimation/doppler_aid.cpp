#include <cmath>
#include <utility>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"

namespace uwsim {
namespace {

/// Observes each beam's velocity separately, b . (R^T v + omega x r) + bias, so that even one or two good beams help.
/// With the errors of scale s and misalignment m, the beam is (1 + s) (b + m x b).
class DopplerAid final : public Aid {
 public:
  DopplerAid(Eigen::MatrixX3d beams, const Eigen::Vector3d& lever, const DopplerErrors& errors)
      : beams_(std::move(beams)), lever_(lever), variance_(errors.std * errors.std), errors_(errors) {}

  int width() const override { return static_cast<int>(beams_.rows()); }
  std::vector<BiasModel> biases() const override {
    std::vector<BiasModel> all(static_cast<std::size_t>(width()), errors_.bias);
    if (errors_.scale.exists()) all.push_back(errors_.scale);
    if (errors_.misalignment.exists()) all.insert(all.end(), 3, errors_.misalignment);
    return all;
  }
  ErrorIndex seen() const override { return kVelocity; }

  void correct(FilterState& state, const double* reading) const override {
    for (int k = 0; k < width(); ++k) {
      if (std::isfinite(reading[k])) correct_beam(state, k, reading[k]);
    }
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, beams_, lever_);
    exchange_not_negative(archive, variance_);
    exchange_bias(archive, errors_.bias, errors_.scale, errors_.misalignment);
  }

 private:
  int scale() const { return first_bias + width(); }
  int misalignment() const { return scale() + (errors_.scale.exists() ? 1 : 0); }

  void correct_beam(FilterState& state, int k, double speed_m_s) const {
    const Eigen::Vector3d velocity_body = state.orientation.conjugate() * state.velocity_m_s;
    const Eigen::Vector3d velocity = velocity_body + state.rate_rad_s().cross(lever_);
    ErrorVector h = ErrorVector::Zero(state.errors());
    Eigen::Vector3d beam = beams_.row(k).transpose();
    const double scaled = errors_.scale.exists() ? 1 + state.aid_bias[scale() - kAidBias] : 1;
    if (errors_.misalignment.exists()) {
      h.segment<3>(misalignment()) = scaled * beam.cross(velocity);
      beam += state.aid_bias.segment<3>(misalignment() - kAidBias).cross(beam).eval();
    }
    if (errors_.scale.exists()) {
      h[scale()] = beam.dot(velocity);
      beam *= scaled;
    }
    const double expected = beam.dot(velocity) + state.aid_bias[first_bias - kAidBias + k];
    h.segment<3>(kVelocity) = state.orientation * beam;
    h.segment<3>(kAttitude) = beam.cross(velocity_body);
    h.segment<3>(kRateBias) = beam.cross(lever_);
    h[first_bias + k] = 1;
    Aid::correct(state, speed_m_s - expected, h, variance_);
  }

  Eigen::MatrixX3d beams_;
  Eigen::Vector3d lever_;
  double variance_;
  DopplerErrors errors_;
};

}  // namespace

std::unique_ptr<Aid> doppler_aid(const Eigen::MatrixX3d& beams_body, const Eigen::Vector3d& lever_body_m,
                                 const DopplerErrors& errors) {
  return std::make_unique<DopplerAid>(beams_body, lever_body_m, errors);
}

}  // namespace uwsim
