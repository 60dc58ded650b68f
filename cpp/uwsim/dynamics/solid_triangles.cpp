#include "uwsim/dynamics/solid_triangles.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <utility>

namespace uwsim {
namespace {

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

struct Tree {
  std::shared_ptr<const Solid> solid;  // owns the arrays that Bullet's shape points into
  std::size_t index;
  InternalEdges edges;
  btTriangleIndexVertexArray arrays;
  std::unique_ptr<btBvhTriangleMeshShape> shape;

  Tree(std::shared_ptr<const Solid> source, std::size_t number)
      : solid(std::move(source)), index(number), edges(solid->mesh_world) {
    const TriangleMesh& mesh = solid->mesh_world;
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(mesh.triangles.size());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.triangles.data());
    part.m_triangleIndexStride = sizeof(Triangle);
    part.m_numVertices = static_cast<int>(mesh.vertices_m.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.vertices_m.data());
    part.m_vertexStride = sizeof(Eigen::Vector3d);
    part.m_vertexType = PHY_DOUBLE;
    arrays.addIndexedMesh(part, PHY_INTEGER);
    shape = std::make_unique<btBvhTriangleMeshShape>(&arrays, false);
  }
};

/// Visits the solids whose boxes overlap, and of each the triangles whose boxes overlap.
struct Search final : btDbvt::ICollide, btTriangleCallback {
  btVector3 low, high;
  const Tree* tree = nullptr;
  std::vector<SolidTriangles::Index>* found = nullptr;

  void Process(const btDbvtNode* leaf) override {
    tree = static_cast<const Tree*>(leaf->data);
    tree->shape->processAllTriangles(this, low, high);
  }
  void processTriangle(btVector3*, int, int triangle) override {
    found->push_back({tree->index, static_cast<std::size_t>(triangle)});
  }
};

}  // namespace

struct SolidTriangles::Impl {
  std::vector<std::unique_ptr<Tree>> trees;
  btDbvt boxes;
  btAlignedObjectArray<const btDbvtNode*> stack;  // kept so that steps allocate nothing
};

SolidTriangles::SolidTriangles(const World& world) : impl_(std::make_unique<Impl>()) {
  impl_->stack.reserve(btDbvt::DOUBLE_STACKSIZE);
  for (const auto& solid : world.solids()) {
    impl_->trees.push_back(std::make_unique<Tree>(solid, impl_->trees.size()));
    btVector3 low, high;
    impl_->trees.back()->shape->getAabb(btTransform::getIdentity(), low, high);
    impl_->boxes.insert(btDbvtVolume::FromMM(low, high), impl_->trees.back().get());
  }
}
SolidTriangles::~SolidTriangles() = default;
SolidTriangles::SolidTriangles(SolidTriangles&&) noexcept = default;
SolidTriangles& SolidTriangles::operator=(SolidTriangles&&) noexcept = default;

void SolidTriangles::find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m,
                          std::vector<Index>& found) {
  found.clear();
  Search search;
  search.low = to_bullet(low_world_m);
  search.high = to_bullet(high_world_m);
  search.found = &found;
  impl_->boxes.collideTVNoStackAlloc(impl_->boxes.m_root, btDbvtVolume::FromMM(search.low, search.high), impl_->stack,
                                     search);
}

std::array<Eigen::Vector3d, 3> SolidTriangles::corners_world_m(const Index& index) const {
  const TriangleMesh& mesh = impl_->trees[index.solid]->solid->mesh_world;
  const auto& [a, b, c] = mesh.triangles[index.triangle];
  return {mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]};
}

const InternalEdges& SolidTriangles::edges(const Index& index) const { return impl_->trees[index.solid]->edges; }

}  // namespace uwsim
