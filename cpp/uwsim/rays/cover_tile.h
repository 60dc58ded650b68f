#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "uwsim/core/built_when_used.h"
#include "uwsim/core/corner_normals.h"
#include "uwsim/core/fork_safe_mutex.h"
#include "uwsim/rays/embree_tree.h"
#include "uwsim/rays/triangle_hit.h"
#include "uwsim/world/cover_plan.h"
#include "uwsim/world/sway.h"

namespace uwsim {

/// A mesh of a layer of cover, with Embree's tree of it.
struct CoverShape {
  CoverShape(RTCDeviceTy* device, const TriangleMesh& mesh, const CoverLayer& of_layer);

  const CoverLayer* layer;
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Triangle> triangles;
  CornerNormals normals;
  RayTree tree;
  float across = 0;         ///< the largest distance of a vertex from the z axis
  float low = 0, high = 0;  ///< bounds of their z; 0 is between
};

/// How the plants of one layer lean in a tile at one time: what is above a plant's foot turns with its z axis, so that
/// a plant keeps its length and its stem its width.
class Lean {
 public:
  Lean() = default;
  /// `top`: see Sway::lean.
  explicit Lean(const Eigen::Vector2d& top);
  /// Neighbours are not equally stiff: the lean of the piece with a number.
  Lean of(std::uint32_t piece) const;
  bool upright() const { return top_.isZero(0); }
  /// The displacement of a point one metre above the foot.
  const Eigen::Vector3d& shift() const { return shift_; }

  /// A point relative to a plant's foot, once it leans.
  Eigen::Vector3d leaned(const Eigen::Vector3d& upright) const { return upright + upright.z() * shift_; }

  static constexpr double kFarthest = 4;  ///< tangent of the largest lean; a plant that lies lower would touch the bed

 private:
  Eigen::Vector2d top_ = Eigen::Vector2d::Zero();
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();
};

/// The pieces of a tile of cover as a target of rays.
class CoverTile {
 public:
  CoverTile(RTCDeviceTy* device, std::span<const CoverShape> shapes, CoverTilePlan plan);
  CoverTile(const CoverTile&) = delete;
  CoverTile& operator=(const CoverTile&) = delete;

  const std::vector<CoverPiece>& pieces() const { return pieces_; }
  std::size_t items() const { return pieces_.size(); }
  const Eigen::Vector3d& middle_m() const { return middle_m_; }
  bool sways() const { return soft_ > 0; }
  /// Holds all pieces, however they lean.
  const Eigen::AlignedBox3d& box() const { return box_; }

  /// Some of the pieces, and the box around them.
  struct Target {
    RayTree tree;
    Eigen::AlignedBox3d box;
  };
  /// The pieces that sway, at one time.
  class Plants {
   public:
    Plants(const CoverTile& tile, std::shared_ptr<const Sway> sway);
    const Sway& sway() const { return *sway_; }
    const Eigen::AlignedBox3d& box() const { return box_; }
    /// The lean of each shape's layer, by the number of the shape.
    std::span<const Lean> leans() const { return leans_; }
    /// Built when a ray first enters the box.
    const Target& target() const;

   private:
    const CoverTile& tile_;
    std::shared_ptr<const Sway> sway_;
    std::vector<Lean> leans_;
    Eigen::AlignedBox3d box_;
    BuiltWhenUsed<Target> target_;
  };
  /// All pieces upright.
  const Target& still() const { return still_; }
  /// Those that do not sway.
  const Target& stiff() const;
  /// Those that sway. The latest are kept, since all rays of a picture or ping are cast at one time.
  std::shared_ptr<const Plants> plants(const std::shared_ptr<const Sway>& sway) const;

  /// The corners of a piece's triangle, in the world. `leans` may be empty.
  Corners corners(const CoverPiece& piece, std::uint32_t triangle, std::span<const Lean> leans) const;
  /// The smooth surface at a place of a piece's triangle, in the world; none for flat shapes and for plants that lean.
  SmoothPlace smooth(const CoverPiece& piece, std::uint32_t triangle, float u, float v,
                     std::span<const Lean> leans) const;
  /// The smaller of `nearest_m` and the distance to the nearest triangle of a piece.
  double distance(const Eigen::Vector3d& point_world_m, double nearest_m, std::span<const Lean> leans) const;

 private:
  enum class Which : std::uint8_t { kAll, kStiff, kSoft };
  Target target(Which which, std::span<const Lean> leans = {}) const;

  RTCDeviceTy* device_;
  std::span<const CoverShape> shapes_;
  Eigen::Vector3d middle_m_, soft_middle_m_;
  std::vector<CoverPiece> pieces_;
  std::size_t soft_ = 0;  // how many of these sway
  Target still_;
  Eigen::AlignedBox3d box_;
  BuiltWhenUsed<Target> stiff_;
  mutable ForkSafeMutex<std::mutex> changing_;
  mutable std::shared_ptr<const Plants> plants_;
};

}  // namespace uwsim
