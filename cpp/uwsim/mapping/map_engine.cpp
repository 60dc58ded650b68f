#include "uwsim/mapping/map_engine.h"

#include <cmath>

#include "uwsim/core/check.h"

namespace uwsim {

float OccupancyModel::log_odds(double probability) {
  return static_cast<float>(std::log(probability / (1 - probability)));
}

void OccupancyModel::check() const {
  require(hit >= 0.5 && hit < 1, "map.hit", hit, "must be in [0.5, 1)");
  require(miss > 0 && miss <= 0.5, "map.miss", miss, "must be in (0, 0.5]");
  require(clamping_min > 0 && clamping_min < 1, "map.clamping_min", clamping_min, "must be in (0, 1)");
  require(clamping_max > clamping_min && clamping_max < 1, "map.clamping_max", clamping_max,
          "must be greater than map.clamping_min and less than 1");
}

}  // namespace uwsim
