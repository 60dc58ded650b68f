#include "uwsim/estimation/water_above.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "uwsim/estimation/swinging_noise.h"

namespace uwsim {
namespace {

constexpr double kTide_rad_s = 2 * std::numbers::pi / 44714;  // M2
// Assumed, both: the thickness of layers of different water, and the depth above which a column is not followed.
constexpr double kLayer_m = 10, kShallow_m = 1;

}  // namespace

std::vector<BiasModel> WaterAbove::first() const {
  const BiasModel level{.turn_on_std = level_std_m_, .of_water = true}, column{.of_water = true};
  return {level, level, column};
}

void WaterAbove::age(FilterState& state, int first, double level_variance, double depth_m, double sinking_m_s,
                     double dt_s) const {
  if (level_variance > 0) swing(state, first, kTide_rad_s, level_variance, dt_s);
  const int column = first + 2;
  if (!(state.covariance(column, column) > 0)) return;
  const double depth = std::max(depth_m, kShallow_m), deeper = std::max(depth_m + sinking_m_s * dt_s, kShallow_m);
  const double share = std::exp(-kLayer_m * std::abs(sinking_m_s) * dt_s / (depth * depth));
  const double kept = std::sqrt(share) * deeper / depth, std_m = column_std_ * deeper;
  state.aid_bias[column - kAidBias] *= kept;
  state.covariance.row(column) *= kept;
  state.covariance.col(column) *= kept;
  state.covariance(column, column) += (1 - share) * std_m * std_m;
}

void WaterAbove::begin(FilterState& state, int first, double depth_m) const {
  double& variance = state.covariance(first + 2, first + 2);
  const double std_m = column_std_ * std::max(depth_m, kShallow_m);
  if (variance == 0) variance = std_m * std_m;
}

void WaterAbove::doubt(FilterState& state, int first, double depth_m, double residual_m, double most_level_m) const {
  const auto grow = [&](int k, double error, double std) {
    state.covariance(k, k) = std::max(state.covariance(k, k), std::min(error * error, std * std));
  };
  grow(first, residual_m, most_level_m);
  grow(first + 2, residual_m, column_std_ * std::max(depth_m, kShallow_m));
}

}  // namespace uwsim
