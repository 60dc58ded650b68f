#include "uwsim/dynamics/solid_triangles.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <cstdint>
#include <utility>

#include "uwsim/core/built_when_used.h"
#include "uwsim/core/infinity.h"
#include "uwsim/dynamics/bullet_memory.h"
#include "uwsim/dynamics/mesh_edges.h"

namespace uwsim {
namespace {

constexpr std::size_t kReservedTriangles = 1024;  // of a solid near a body; a step that needs more allocates

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// A solid's triangles for searches.
struct Tree {
  MeshEdges edges;
  btTriangleIndexVertexArray arrays;
  btBvhTriangleMeshShape shape;

  explicit Tree(const TriangleMesh& mesh) : edges(mesh), arrays(indexed(mesh)), shape(&arrays, false) {}

  static btTriangleIndexVertexArray indexed(const TriangleMesh& mesh) {
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(mesh.triangles.size());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.triangles.data());
    part.m_triangleIndexStride = sizeof(Triangle);
    part.m_numVertices = static_cast<int>(mesh.vertices_m.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.vertices_m.data());
    part.m_vertexStride = sizeof(Eigen::Vector3d);
    part.m_vertexType = PHY_DOUBLE;
    btTriangleIndexVertexArray arrays;
    arrays.addIndexedMesh(part, PHY_INTEGER);
    return arrays;
  }
};

/// A solid whose tree is built when a body first comes close: most runs touch few solids.
struct SearchedSolid {
  std::shared_ptr<const Solid> solid;  // owns the arrays that Bullet's shape refers to
  BuiltWhenUsed<std::unique_ptr<Tree>> built;

  explicit SearchedSolid(std::shared_ptr<const Solid> source) : solid(std::move(source)) {}

  const Tree& tree() const {
    return *built.get([this] { return std::make_unique<Tree>(solid->mesh_world); });
  }

  /// The bounds of the triangles, as middle and half size, like Bullet's.
  btDbvtVolume box() const {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(kInfinity), high = -low;
    for (const Triangle& triangle : solid->mesh_world.triangles) {
      for (const auto vertex : triangle) {
        low = low.cwiseMin(solid->mesh_world.vertices_m[vertex]);
        high = high.cwiseMax(solid->mesh_world.vertices_m[vertex]);
      }
    }
    return btDbvtVolume::FromCE(to_bullet(0.5 * (high + low)), to_bullet(0.5 * (high - low)));
  }
};

/// Visits the solids whose bounding boxes overlap the search box and, in each solid, the triangles whose bounding boxes
/// do.
struct Search final : btDbvt::ICollide, btTriangleCallback {
  btVector3 low, high;
  const MeshEdges* edges = nullptr;
  std::vector<SurfacePatch>* patches = nullptr;
  std::size_t count = 0;
  std::size_t triangles = 0, most_triangles = 0;  // beyond the maximum, triangles are only counted

  void Process(const btDbvtNode* leaf) override {
    const Tree& tree = static_cast<const SearchedSolid*>(leaf->data)->tree();
    edges = &tree.edges;
    if (count == patches->size()) patches->emplace_back().reserve(kReservedTriangles);
    SurfacePatch& patch = (*patches)[count];
    patch.clear();
    tree.shape.processAllTriangles(this, low, high);
    if (!patch.triangles.empty()) ++count;
  }
  void processTriangle(btVector3*, int, int triangle) override {
    if (++triangles <= most_triangles) edges->add_triangle(static_cast<std::uint32_t>(triangle), (*patches)[count]);
  }
};

}  // namespace

struct SolidTriangles::Impl {
  std::vector<std::unique_ptr<SearchedSolid>> solids;
  btDbvt boxes;
};

struct SolidTriangles::Stack::Impl {
  btAlignedObjectArray<const btDbvtNode*> nodes;
};

SolidTriangles::Stack::Stack() : impl_(std::make_unique<Impl>()) { impl_->nodes.reserve(btDbvt::DOUBLE_STACKSIZE); }
SolidTriangles::Stack::~Stack() = default;
SolidTriangles::Stack::Stack(Stack&&) noexcept = default;
SolidTriangles::Stack& SolidTriangles::Stack::operator=(Stack&&) noexcept = default;

SolidTriangles::SolidTriangles(const World& world) : impl_(std::make_unique<Impl>()) {
  for (const auto& solid : world.solids()) {
    impl_->solids.push_back(std::make_unique<SearchedSolid>(solid));
    impl_->boxes.insert(impl_->solids.back()->box(), impl_->solids.back().get());
  }
}
SolidTriangles::~SolidTriangles() = default;
SolidTriangles::SolidTriangles(SolidTriangles&&) noexcept = default;
SolidTriangles& SolidTriangles::operator=(SolidTriangles&&) noexcept = default;

std::size_t SolidTriangles::find(const Eigen::Vector3d& low_world_m, const Eigen::Vector3d& high_world_m, Stack& stack,
                                 std::vector<SurfacePatch>& patches, ContactBudget& budget) const {
  Search search;
  search.low = to_bullet(low_world_m);
  search.high = to_bullet(high_world_m);
  search.patches = &patches;
  search.most_triangles = budget.triangles_left();
  impl_->boxes.collideTVNoStackAlloc(impl_->boxes.m_root, btDbvtVolume::FromMM(search.low, search.high),
                                     stack.impl_->nodes, search);
  budget.spend_on_triangles(search.triangles);
  return search.count;
}

}  // namespace uwsim
