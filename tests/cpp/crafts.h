#pragma once

#include <memory>

#include "meshes.h"
#include "uwsim/vehicle/hydrodynamics.h"

namespace uwsim {

/// The box of most tests.
inline TriangleMesh brick() { return testing::box(1.2, 0.8, 0.6); }

/// A body of even density without added mass and damping.
inline CraftParameters solid_of(const TriangleMesh& mesh, double density_kg_m3) {
  const SolidProperties solid = solid_properties(mesh);
  CraftParameters p;
  p.mass_kg = density_kg_m3 * solid.volume_m3;
  p.inertia_kg_m2 = density_kg_m3 * solid.inertia_per_density_m5;
  return p;
}

inline CraftParameters brick_parameters(double density_kg_m3) { return solid_of(brick(), density_kg_m3); }

inline std::shared_ptr<const Craft> craft_of(const CraftParameters& p, const TriangleMesh& mesh = brick()) {
  return std::make_shared<const Craft>(p, BuoyantHull(mesh));
}

}  // namespace uwsim
