#include "uwsim/camera/picture.h"

namespace uwsim {

void PictureCost::add(const PictureCost& other) {
  primary_rays += other.primary_rays;
  onward_rays += other.onward_rays;
  sun_rays += other.sun_rays;
  lamp_rays += other.lamp_rays;
  shaft_rays += other.shaft_rays;
  for (std::size_t k = 0; k < seconds.size(); ++k) seconds[k] += other.seconds[k];
}

}  // namespace uwsim
