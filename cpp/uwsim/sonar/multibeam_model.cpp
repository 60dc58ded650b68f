#include "uwsim/sonar/multibeam_model.h"

#include <array>
#include <numbers>

#include "uwsim/core/check.h"

namespace uwsim {

const MultibeamModel& em2040(int number) {
  constexpr double kDegree = std::numbers::pi / 180;
  static const std::array<MultibeamModel, 4> models = {{
      {1, "EM 2040 MKII, 600 kHz, single swath", 513, 85 * kDegree, 95, 94.9, 600e3, false},
      {2, "EM 2040 MKII, 700 kHz, single swath", 513, 85 * kDegree, 55, 54.9, 700e3, false},
      {3, "EM 2040 MKII, 600 kHz, dual swath", 1025, 170 * kDegree, 95, 94.9, 600e3, true},
      {4, "EM 2040 MKII, 700 kHz, dual swath", 1025, 170 * kDegree, 55, 54.9, 700e3, true},
  }};
  require(number >= 1 && number <= 4, "sonar.model", number, "must be 1, 2, 3 or 4");
  return models[static_cast<std::size_t>(number - 1)];
}

}  // namespace uwsim
