#include "uwsim/dynamics/bullet_ground.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <optional>

#include "uwsim/core/recently_made.h"
#include "uwsim/dynamics/bullet_memory.h"
#include "uwsim/world/same_surfaces.h"

namespace uwsim {

struct BulletGround::Shapes {
  std::optional<btHeightfieldTerrainShape> terrain;
  btTriangleIndexVertexArray arrays;
  std::optional<btBvhTriangleMeshShape> solids;
};

BulletGround::BulletGround(const World& source) : world_(source), shapes_(std::make_unique<Shapes>()) {
  world_.water = {};
  if (const auto& terrain = world_.terrain()) {
    // Bullet divides each cell along the same diagonal as Heightfield, and puts the shape's origin at its middle.
    const double low_m = terrain->lowest_m(), high_m = terrain->highest_m();
    shapes_->terrain.emplace(static_cast<int>(terrain->nx()), static_cast<int>(terrain->ny()),
                             terrain->heights_m().data(), low_m, high_m, 2, false);
    shapes_->terrain->setLocalScaling({terrain->spacing_m(), terrain->spacing_m(), 1});
    const Eigen::Vector2d middle_m = 0.5 * (terrain->origin_m() + terrain->far_corner_m());
    parts_.push_back({&*shapes_->terrain, {middle_m.x(), middle_m.y(), 0.5 * (low_m + high_m)}});
  }
  for (const auto& solid : world_.solids()) {
    const TriangleMesh& mesh = solid->mesh_world;
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(mesh.triangles.size());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.triangles.data());
    part.m_triangleIndexStride = sizeof(Triangle);
    part.m_numVertices = static_cast<int>(mesh.vertices_m.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.vertices_m.data());
    part.m_vertexStride = sizeof(Eigen::Vector3d);
    part.m_vertexType = PHY_DOUBLE;
    shapes_->arrays.addIndexedMesh(part, PHY_INTEGER);
  }
  if (!world_.solids().empty()) {
    // Without compression, there is no limit on the number of solids.
    shapes_->solids.emplace(&shapes_->arrays, false);
    parts_.push_back({&*shapes_->solids, Eigen::Vector3d::Zero()});
  }
}

BulletGround::~BulletGround() = default;

std::shared_ptr<const BulletGround> BulletGround::of(const World& world) {
  static RecentlyMade<BulletGround> known;
  return known.find_or_make(
      false, [&](const BulletGround& other) { return have_same_surfaces(other.world_, world); },
      [&] { return std::make_shared<const BulletGround>(world); });
}

}  // namespace uwsim
