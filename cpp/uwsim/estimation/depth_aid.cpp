#include <algorithm>
#include <cmath>

#include "uwsim/estimation/aid.h"
#include "uwsim/estimation/exchanged_values.h"
#include "uwsim/estimation/water_above.h"
#include "uwsim/estimation/wave_pressure.h"

namespace uwsim {
namespace {

/// Observes the weight of the water above it as a depth in water of the surface's density, level - (p + R r)_z + column
/// + bias + head of the waves' pressure.
class DepthAid final : public Aid {
 public:
  DepthAid(const Eigen::Vector3d& lever, double std, const BiasModel& bias, const WaterErrors& water)
      : lever_(lever),
        variance_(std * std),
        bias_(bias),
        waves_(waves(water.wave_std_m)),
        above_(water.level_std_m, water.column_std) {}

  int width() const override { return 1; }
  std::vector<BiasModel> biases() const override {
    std::vector<BiasModel> all = {bias_, waves_.first(), waves_.first()};
    for (const BiasModel& each : above_.first()) all.push_back(each);
    return all;
  }
  ErrorIndex seen() const override { return kPosition; }

  void begin(FilterState& state) const override {
    wave_variance(state) = waves_.first().variance();
    level_variance(state) = above_.level_std_m() * above_.level_std_m();
  }
  void age(FilterState& state, double dt_s) const override {
    waves_.age(state, first_bias + kWaves, wave_variance(state), dt_s);
    const double sinking_m_s = -state.velocity_m_s.z();
    above_.age(state, first_bias + kLevel, level_variance(state), depth_m(state), sinking_m_s, dt_s);
  }

  void correct(FilterState& state, const double* reading) const override {
    const Eigen::Vector3d up_body = state.orientation.conjugate() * Eigen::Vector3d::UnitZ();
    const auto bias = state.aid_bias.segment<kLevel + WaterAbove::kErrors>(first_bias - kAidBias);
    const double expected = depth_m(state) + bias[kColumn] + bias[0] + bias[kHead];
    if (expected < 0 && reading[0] < dry_m()) return;
    above_.begin(state, first_bias + kLevel, reading[0]);
    ErrorVector h = ErrorVector::Zero(state.errors());
    h[kPosition + 2] = -1;
    h.segment<3>(kAttitude) = up_body.cross(lever_);
    h[first_bias] = h[first_bias + kHead] = h[first_bias + kLevel] = h[first_bias + kColumn] = 1;
    Aid::correct(state, reading[0] - expected, h, variance_);
  }

  /// A vehicle that seems higher may lie under higher water, even beyond the expected.
  void contradict(FilterState& state, double up_m) const override {
    if (above_.level_std_m() > 0) level_variance(state) = std::max(level_variance(state), up_m * up_m);
    above_.doubt(state, first_bias + kLevel, depth_m(state), up_m, std::sqrt(level_variance(state)));
  }

  void exchange_parameters(StateArchive& archive) override {
    exchange_numbers(archive, lever_);
    exchange_not_negative(archive, variance_);
    exchange_bias(archive, bias_);
    double wave_std = waves_.first_std_m(), level_std = above_.level_std_m(), column_std = above_.column_std();
    exchange_not_negative(archive, wave_std, level_std, column_std);
    waves_ = waves(wave_std);
    above_ = {level_std, column_std};
  }

 private:
  // The biases, in order: the instrument's, the waves', of which the second is the head, and those of the water above.
  static constexpr int kWaves = 1, kHead = kWaves + 1, kLevel = kWaves + WavePressure::kErrors, kColumn = kLevel + 2;
  /// Readings are white noise whose mean over a second is about a fifth of `variance_`, at usual rates; smaller waves
  /// do not matter.
  WavePressure waves(double wave_std) const { return {wave_std, wave_std > 0 ? 0.2 * std::sqrt(variance_) : 0}; }
  /// Below the still surface, of the gauge.
  double depth_m(const FilterState& state) const {
    const double level = state.aid_bias[first_bias + kLevel - kAidBias];
    return level - state.position_m.z() - (state.orientation * lever_).z();
  }
  double& wave_variance(FilterState& state) const {
    return state.counts[static_cast<std::size_t>(index)].noise_variance;
  }
  double& level_variance(FilterState& state) const {
    return state.counts[static_cast<std::size_t>(index)].level_variance;
  }
  /// A gauge in air reads 0, however high it is, plus its errors: where the estimate is above the water as well, such a
  /// reading contains no information.
  double dry_m() const { return kGate * std::sqrt(variance_ + bias_.variance()); }
  /// An outlier may be a jump in depth, a wave that is higher than those before, or other water: all become plausible
  /// from now on.
  void doubt(FilterState& state, double residual) const override {
    Aid::doubt(state, residual);
    above_.doubt(state, first_bias + kLevel, depth_m(state), residual, above_.level_std_m());
    const double wave_m = residual / kGate;
    if (waves_.first_std_m() > 0) wave_variance(state) = std::max(wave_variance(state), wave_m * wave_m);
  }

  Eigen::Vector3d lever_;
  double variance_;
  BiasModel bias_;
  WavePressure waves_;
  WaterAbove above_;
};

}  // namespace

std::unique_ptr<Aid> depth_aid(const Eigen::Vector3d& lever_body_m, double std, const BiasModel& bias,
                               const WaterErrors& water) {
  return std::make_unique<DepthAid>(lever_body_m, std, bias, water);
}

}  // namespace uwsim
