#include "uwsim/sim/arm_surfaces.h"

namespace uwsim {

std::vector<Pose> link_surfaces_world(const RigidBodyWorld& bodies) {
  std::vector<Pose> found;
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    const Arm* const arm = bodies.arm(body);
    if (arm == nullptr) continue;
    const std::vector<Pose> poses = arm->world_from_links(bodies.state(body).world_from_body);
    for (std::size_t k = 0; k < poses.size(); ++k) {
      if (arm->links()[k].surface_m != nullptr) found.push_back(poses[k]);
    }
  }
  return found;
}

bool has_link_surfaces(const RigidBodyWorld& bodies) {
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (bodies.arm(body) == nullptr) continue;
    for (const ArmLink& link : bodies.arm(body)->links()) {
      if (link.surface_m != nullptr) return true;
    }
  }
  return false;
}

void add_link_surfaces(const RigidBodyWorld& bodies, MovingBodies& targets) {
  if (!has_link_surfaces(bodies)) return;
  targets.add_after_schools();
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (bodies.arm(body) == nullptr) continue;
    for (const ArmLink& link : bodies.arm(body)->links()) {
      if (link.surface_m != nullptr) targets.add(*link.surface_m);
    }
  }
}

}  // namespace uwsim
