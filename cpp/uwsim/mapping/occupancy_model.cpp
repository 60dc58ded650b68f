#include "uwsim/mapping/occupancy_model.h"

#include "uwsim/core/check.h"

namespace uwsim {

OccupancyLogOdds OccupancyModel::in_log_odds() const {
  return {log_odds_of(hit), log_odds_of(miss), log_odds_of(clamping_min), log_odds_of(clamping_max)};
}

void OccupancyModel::check() const {
  require(hit >= 0.5 && hit < 1, "map.hit", hit, "must be in [0.5, 1)");
  require(miss > 0 && miss <= 0.5, "map.miss", miss, "must be in (0, 0.5]");
  require(clamping_min > 0 && clamping_min < 1, "map.clamping_min", clamping_min, "must be in (0, 1)");
  require(clamping_max > clamping_min && clamping_max < 1, "map.clamping_max", clamping_max,
          "must be greater than map.clamping_min and less than 1");
}

}  // namespace uwsim
