#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "uwsim/core/random.h"
#include "uwsim/rays/ray_scene.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// One piece of cover: a point p of its mesh lies at tile's middle + at_m + turn p. The floats are the piece's place
/// itself, so that Embree and double precision use the same one.
struct CoverPiece {
  Eigen::Vector3f at_m;
  Eigen::Matrix3f turn;  ///< rotation times size
  float size_m;
  std::uint32_t mesh;  ///< counted over the meshes of all layers
  std::uint16_t layer;
  std::uint32_t number;  ///< unique in the world
};

struct CoverTilePlan {
  Eigen::Vector3d middle_m;
  std::vector<CoverPiece> pieces;
};

/// Where the pieces of a world's cover are. The terrain is divided into square tiles, of about a thousand pieces each,
/// and a tile's pieces are drawn from counter-based random numbers, keyed by layer, seed and tile: they depend neither
/// on the order in which tiles are made nor on the number of threads.
class CoverPlan {
 public:
  explicit CoverPlan(const World& surfaces);

  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  double tile_m() const { return tile_m_; }
  const Eigen::Vector2d& origin_m() const { return origin_m_; }
  /// How far a piece extends at most from its origin, which lies in its tile.
  double reach_m() const { return reach_m_; }
  /// The pieces of a tile, in an order that depends on the world alone.
  CoverTilePlan pieces(std::uint32_t column, std::uint32_t row) const;

 private:
  /// A layer with what follows from it.
  struct Growth {
    std::shared_ptr<const CoverLayer> layer;
    RandomStream stream, patches;
    std::uint32_t first_mesh;
    std::vector<double> reach;  ///< of each mesh, per metre of size
    std::vector<double> top;    ///< height of each mesh above its origin, per metre of size
    double threshold;           ///< of the patches' noise
    std::uint32_t first_number;
  };
  void add_piece(const Growth& growth, std::uint64_t tile, std::uint32_t k, CoverTilePlan& plan) const;
  bool grows_at(const Growth& growth, const Eigen::Vector3d& foot_m, const Eigen::Vector3d& up) const;
  double from_surfaces(const Eigen::Vector3d& foot_m, double enough_m) const;

  World surfaces_;
  std::shared_ptr<const RayScene> solids_;  // null if there are none
  std::vector<Growth> growths_;
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  double tile_m_ = 1, reach_m_ = 0;
  std::uint32_t columns_ = 0, rows_ = 0, numbers_a_tile_ = 0;
};

}  // namespace uwsim
