#include "uwsim/sim/arm_surfaces.h"

namespace uwsim {

void add_link_surface_poses(const RigidBodyWorld& bodies, std::vector<Pose>& poses) {
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    const Arm* const arm = bodies.arm(body);
    if (arm == nullptr) continue;
    const std::size_t first = poses.size();
    arm->add_link_poses(bodies.state(body).world_from_body, poses);
    std::size_t kept = first;
    for (std::size_t k = 0; k < arm->size(); ++k) {
      if (arm->links()[k].surface_m != nullptr) poses[kept++] = poses[first + k];
    }
    poses.resize(kept);
  }
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
