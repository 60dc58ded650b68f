#include "uwsim/camera/lamp.h"

#include "uwsim/core/check.h"

namespace uwsim {

void SpotLamp::check() const {
  require(world_from_lamp.position_m.allFinite(), "lamp.position_m", world_from_lamp.position_m.transpose(),
          "must be finite");
  require(flux_lm >= 0 && flux_lm <= 1e8, "lamp.flux_lm", flux_lm, "must be in [0, 1e8] lm");
  require(half_angle_rad >= 0.01 && half_angle_rad <= 1.5, "lamp.half_angle_rad", half_angle_rad,
          "must be in [0.01, 1.5] rad");
  require(soft_share >= 0.01 && soft_share <= 1, "lamp.soft_share", soft_share, "must be in [0.01, 1]");
  require((colour >= 0).all() && (colour <= 10).all(), "lamp.colour", colour.transpose(), "must be in [0, 10]");
}

}  // namespace uwsim
