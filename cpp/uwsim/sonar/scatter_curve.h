#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "uwsim/acoustics/sonar_equation.h"

namespace uwsim {

/// A surface's backscattering cross-section per unit area by incidence: its seabed's curve, tabulated every 0.1 degree,
/// or Lambert's law. A frequency or speed of sound outside the seabed model's range of validity is replaced by the
/// nearest one within that range.
class ScatterCurve {
 public:
  ScatterCurve(const BottomMaterial& material, double frequency_hz, double sound_speed_m_s);

  /// As a ratio; `cosine`, of the incidence, is in [0, 1].
  float operator()(float cosine) const {
    if (table_.empty()) return strength_ * cosine * cosine;
    const float at = std::acos(cosine) * kPerRadian;
    const auto below = static_cast<std::size_t>(at);
    if (below + 1 >= table_.size()) return table_.back();
    return table_[below] + (at - static_cast<float>(below)) * (table_[below + 1] - table_[below]);
  }

 private:
  static constexpr std::size_t kSteps = 900;
  static constexpr float kPerRadian = kSteps * 2 / std::numbers::pi_v<float>;

  float strength_;  // at normal incidence, by Lambert's law
  std::vector<float> table_;
};

}  // namespace uwsim
