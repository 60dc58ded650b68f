#include "bindings/binders.h"
#include "bindings/sonar/binders.h"

namespace uwsim::bindings {

void bind_sonar(pybind11::module_& m) {
  bind_multibeam(m);
  bind_acoustic_multibeam(m);
  bind_imaging(m);
  bind_high_points(m);
  bind_depth_image(m);
  bind_depth_string(m);
}

}  // namespace uwsim::bindings
