#include <algorithm>
#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"
#include "uwsim/estimation/wave_pressure.h"

namespace uwsim {
namespace {

/// Observes the depth, -(p + R r)_z + bias + head of the waves' pressure.
class DepthAid final : public Aid {
 public:
  DepthAid(const Eigen::Vector3d& lever, double std, const BiasModel& bias, double wave_std)
      : lever_(lever), variance_(std * std), bias_(bias), waves_(waves(wave_std)) {}

  int width() const override { return 1; }
  std::vector<BiasModel> biases() const override { return {bias_, waves_.first(), waves_.first()}; }
  int biases_in(std::uint64_t version) const override { return version <= 2 ? 1 : 3; }  // without waves
  ErrorIndex seen() const override { return kPosition; }

  void begin(FilterState& state) const override { wave_variance(state) = waves_.first().variance(); }
  void age(FilterState& state, double dt_s) const override {
    waves_.age(state, first_bias + 1, wave_variance(state), dt_s);
  }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Vector3d up_body = state.orientation.conjugate() * Eigen::Vector3d::UnitZ();
    const auto bias = state.aid_bias.segment<3>(first_bias - kAidBias);
    const double expected = -state.position_m.z() - up_body.dot(lever_) + bias[0] + bias[2];
    if (expected < 0 && reading[0] < dry_m()) return;
    ErrorVector h = ErrorVector::Zero(state.errors());
    h[kPosition + 2] = -1;
    h.segment<3>(kAttitude) = up_body.cross(lever_);
    h[first_bias] = h[first_bias + 2] = 1;
    Aid::correct(state, reading[0] - expected, h, variance_);
  }

  void be_as_in(std::uint64_t version) override {
    if (version <= 2) waves_ = waves(0);
  }
  void exchange_parameters(StateArchive& archive, std::uint64_t version) override {
    exchange_numbers(archive, lever_);
    exchange_not_negative(archive, variance_);
    exchange_bias(archive, bias_);
    double wave_std = waves_.first_std_m();
    if (version >= 3) exchange_not_negative(archive, wave_std);
    waves_ = waves(wave_std);
  }

 private:
  /// Readings are white noise whose mean over a second is about a fifth of `variance_`, at usual rates; smaller waves
  /// do not matter.
  WavePressure waves(double wave_std) const { return {wave_std, wave_std > 0 ? 0.2 * std::sqrt(variance_) : 0}; }
  double& wave_variance(FilterState& state) const {
    return state.counts[static_cast<std::size_t>(index)].noise_variance;
  }
  /// A gauge in air reads 0, however high it is, plus its errors: where the estimate is above the water as well, such a
  /// reading contains no information.
  double dry_m() const { return kGate * std::sqrt(variance_ + bias_.variance()); }
  /// An outlier may be a jump in depth, or a wave that is higher than those before: both become plausible from now on.
  void doubt(FilterState& state, double residual) const override {
    Aid::doubt(state, residual);
    const double wave_m = residual / kGate;
    if (waves_.first_std_m() > 0) wave_variance(state) = std::max(wave_variance(state), wave_m * wave_m);
  }

  Eigen::Vector3d lever_;
  double variance_;
  BiasModel bias_;
  WavePressure waves_;
};

}  // namespace

std::unique_ptr<Aid> depth_aid(const Eigen::Vector3d& lever_body_m, double std, const BiasModel& bias,
                               double wave_std) {
  return std::make_unique<DepthAid>(lever_body_m, std, bias, wave_std);
}

}  // namespace uwsim
