#include "uwsim/camera/optics.h"

#include "uwsim/core/check.h"

namespace uwsim {

void Optics::check() const {
  water.check();
  require(particles_per_m3 >= 0 && particles_per_m3 <= 64, "optics.particles_per_m3", particles_per_m3,
          "must be in [0, 64] 1/m3");
}

}  // namespace uwsim
