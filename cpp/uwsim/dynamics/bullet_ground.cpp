#include "uwsim/dynamics/bullet_ground.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <LinearMath/btAabbUtil2.h>

#include <cstddef>
#include <optional>

#include "uwsim/core/recently_made.h"
#include "uwsim/dynamics/bullet_memory.h"
#include "uwsim/dynamics/contact_shapes.h"
#include "uwsim/world/same_surfaces.h"

namespace uwsim {

namespace {

/// The solid pieces of cover, of which Bullet asks for the triangles near a body.
class CoverShape final : public btConcaveShape {
 public:
  explicit CoverShape(const World& world) : surfaces_(fixed_surfaces(world)) {
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;  // Bullet takes its custom type for a field of distances
    const Heightfield& terrain = *world.terrain();
    const Eigen::Vector2d low = terrain.origin_m(), high = terrain.far_corner_m();
    const double reach_m = surfaces_->cover->reach_m();
    low_ = {low.x() - reach_m, low.y() - reach_m, terrain.lowest_m() - reach_m};
    high_ = {high.x() + reach_m, high.y() + reach_m, terrain.highest_m() + reach_m};
  }

  void processAllTriangles(btTriangleCallback* callback, const btVector3& low, const btVector3& high) const override {
    const auto from_bullet = [](const btVector3& v) { return Eigen::Vector3d(v.x(), v.y(), v.z()); };
    int number = 0;
    surfaces_->cover->visit(from_bullet(low), from_bullet(high), [&](const Corners& corners) {
      btVector3 triangle[3];
      for (std::size_t k = 0; k < 3; ++k) triangle[k] = {corners[k].x(), corners[k].y(), corners[k].z()};
      callback->processTriangle(triangle, 0, number++);
    });
  }
  void getAabb(const btTransform& placed, btVector3& low, btVector3& high) const override {
    btTransformAabb(low_, high_, 0, placed, low, high);
  }
  void setLocalScaling(const btVector3&) override {}
  const btVector3& getLocalScaling() const override { return scaling_; }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "cover"; }

 private:
  std::shared_ptr<const FixedSurfaces> surfaces_;
  btVector3 low_, high_, scaling_{1, 1, 1};
};

}  // namespace

struct BulletGround::Shapes {
  std::optional<btHeightfieldTerrainShape> terrain;
  btTriangleIndexVertexArray arrays;
  std::optional<btBvhTriangleMeshShape> solids;
  std::optional<CoverShape> cover;
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
  if (CoverTriangles::lie_in(world_)) {
    shapes_->cover.emplace(world_);
    parts_.push_back({&*shapes_->cover, Eigen::Vector3d::Zero()});
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
