#include <cmath>
#include <string>

#include "uwsim/core/check.h"
#include "uwsim/sim/simulation.h"

namespace uwsim {
namespace {

constexpr double kWorldEnd_m = 1e6;
constexpr double kSpeedMax = 100;  // m/s and rad/s

}  // namespace

/// Throws if the position is below the ground, inside a solid or inside a solid piece of cover. Contacts push a body
/// away from a surface towards the side on which the body is, so they would keep a body inside a solid if it started
/// there.
void Simulation::require_free(const std::string& path, const Eigen::Vector3d& position) const {
  const double bed_m = world_.terrain() ? world_.terrain()->height_at(position.x(), position.y()) : -kWorldEnd_m;
  require(!(position.z() <= bed_m), path, position.transpose(), "must be above the ground");
  const Solid* const around = world_.solid_around(position);
  if (around != nullptr) require(false, path, position.transpose(), "must be outside '" + around->name + "'");
  const CoverLayer* const cover = bodies_.cover_around(position);
  if (cover != nullptr)
    require(false, path, position.transpose(), "must be outside the pieces of '" + cover->name + "'");
}

void Simulation::set_state(std::size_t index, const BodyState& state) {
  Vehicle& moved = changeable(index);
  const std::string path = "vehicle '" + moved.name + "'";
  const Eigen::Vector3d& position = state.world_from_body.position_m;
  require(state.world_from_body.position_m.allFinite() && state.world_from_body.orientation.coeffs().allFinite() &&
              state.velocity_body.allFinite(),
          path + " state", "non-finite", "must be finite");
  require(position.cwiseAbs().maxCoeff() <= kWorldEnd_m, path + " position_m", position.transpose(),
          "must be within 1000 km of the origin");
  require(state.velocity_body.cwiseAbs().maxCoeff() <= kSpeedMax, path + " velocity_body",
          state.velocity_body.transpose(), "must be at most 100 m/s and rad/s");
  require_free(path + " position_m", position);
  bodies_.require_tethers_reach(moved.body, state.world_from_body, world_.water, time_s());
  release(index);  // otherwise, a docked vehicle would be held in place
  bodies_.set_state(moved.body, state);
  bodies_.lay_tethers(moved.body, world_.water, time_s());
  carry_cargo();
  moved.touching = false;
  ++version_;
}

}  // namespace uwsim
