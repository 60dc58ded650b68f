#include "uwsim/dynamics/dynamics_engine.h"

#include "uwsim/dynamics/bullet_engine.h"
#include "uwsim/dynamics/uwsim_engine.h"

namespace uwsim {

std::unique_ptr<DynamicsEngine> make_engine(EngineKind kind, const World& world, double step_s) {
  if (kind == EngineKind::kBullet) return std::make_unique<BulletEngine>(world, step_s);
  return std::make_unique<UwsimEngine>(world, step_s);
}

}  // namespace uwsim
