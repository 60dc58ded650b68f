#include "uwsim/camera/render_cost.h"

namespace uwsim {

void RenderCost::add(const RenderCost& other) {
  primary_rays += other.primary_rays;
  onward_rays += other.onward_rays;
  sun_rays += other.sun_rays;
  lamp_rays += other.lamp_rays;
  shaft_rays += other.shaft_rays;
  for (std::size_t k = 0; k < seconds.size(); ++k) seconds[k] += other.seconds[k];
}

}  // namespace uwsim
