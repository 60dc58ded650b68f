#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "uwsim/core/random.h"
#include "uwsim/world/world.h"

namespace uwsim {

/// One piece of cover: a point p of its mesh lies at tile's middle + at_m + turn p. The floats are the piece's place
/// itself, so that rays in float, rays in double and contacts use the same one.
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

/// A range of tiles, both ends included; empty if an end is before its start.
struct CoverTiles {
  std::int64_t first_column, last_column, first_row, last_row;
};

/// Where the pieces of a world's cover are. The terrain is divided into square tiles, of about a thousand pieces each,
/// and a tile's pieces are drawn from counter-based random numbers, keyed by layer, seed and tile: they depend neither
/// on the order in which tiles are made nor on the number of threads.
class CoverPlan {
 public:
  enum class Of { kAll, kSolid };  ///< which layers

  explicit CoverPlan(const World& surfaces);

  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  double tile_m() const { return tile_m_; }
  const Eigen::Vector2d& origin_m() const { return origin_m_; }
  /// How far a piece extends at most from its origin, which lies in its tile.
  double reach_m(Of layers = Of::kAll) const { return reach_m_[static_cast<std::size_t>(layers)]; }
  /// The tiles whose squares come within `far_m` of a rectangle.
  CoverTiles tiles_near(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m, double far_m) const;
  /// The pieces of a tile, in an order that depends on the world alone.
  CoverTilePlan pieces(std::uint32_t column, std::uint32_t row, Of layers = Of::kAll) const;
  /// The column and the row of the tile of the piece with a number.
  std::pair<std::uint32_t, std::uint32_t> tile_of(std::uint32_t number) const {
    const std::uint32_t tile = (number - 1) / numbers_a_tile_;
    return {tile % columns_, tile / columns_};
  }
  /// The expected number of a layer's pieces per square metre of the horizontal plane; 0 outside the terrain.
  double density_at(std::size_t layer, const Eigen::Vector2d& at_m) const;
  /// The mean over a layer's pieces of the part of their frontal area that lies lower than a height above the bed
  /// [m^2].
  double frontal_area_below(std::size_t layer, double height_m) const;
  /// The height of the layer's tallest pieces above the bed.
  double tallest_m(std::size_t layer) const { return growths_[layer].tallest_m; }

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
    double tallest_m;
    std::vector<double> frontal_m2;  ///< of a mean piece below heights in equal steps up to the tallest
  };
  /// The distance to the surfaces of all solids: triangles in groups, each with its box.
  class SolidDistance {
   public:
    explicit SolidDistance(const World& surfaces);
    /// Infinity if it is more than `enough_m`.
    double operator()(const Eigen::Vector3d& point_m, double enough_m) const;

   private:
    struct Group {
      Eigen::AlignedBox3d box;
      const TriangleMesh* mesh;
      std::size_t first, last;
    };
    std::vector<Group> groups_;
  };

  void add_piece(const Growth& growth, std::uint64_t tile, std::uint32_t k, CoverTilePlan& plan) const;
  bool grows_at(const Growth& growth, const Eigen::Vector3d& foot_m, const Eigen::Vector3d& up) const;
  static void set_frontal_area(Growth& growth);

  World surfaces_;
  SolidDistance from_solids_;
  std::vector<Growth> growths_;
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  double tile_m_ = 1, reach_m_[2] = {0, 0};
  std::uint32_t columns_ = 0, rows_ = 0, numbers_a_tile_ = 0;
};

}  // namespace uwsim
