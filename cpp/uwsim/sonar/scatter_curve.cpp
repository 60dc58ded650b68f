#include "uwsim/sonar/scatter_curve.h"

#include <algorithm>

namespace uwsim {

ScatterCurve::ScatterCurve(const BottomMaterial& material, double frequency_hz, double sound_speed_m_s)
    : strength_(static_cast<float>(std::pow(10, material.strength_db / 10))) {
  if (!material.seabed) return;
  const SeabedBackscatter backscatter(*material.seabed, std::clamp(frequency_hz, kSeabedLowest_hz, kSeabedHighest_hz),
                                      std::clamp(sound_speed_m_s, 1400.0, 1600.0));
  for (std::size_t k = 0; k <= kSteps; ++k) {
    const double incidence_rad = static_cast<double>(k) / double{kPerRadian};
    table_.push_back(static_cast<float>(backscatter(std::numbers::pi / 2 - incidence_rad)));
  }
}

}  // namespace uwsim
