#include "bindings/binders.h"
#include "bindings/mapping/binders.h"

namespace uwsim::bindings {

void bind_mapping(pybind11::module_& m) {
  bind_clouds(m);
  bind_occupancy_map(m);
  bind_distance_field(m);
}

}  // namespace uwsim::bindings
