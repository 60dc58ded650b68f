#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "uwsim/core/triangle_mesh.h"

namespace uwsim {

/// How the pieces of a layer stand on the bed. All are turned about their own z at random.
enum class CoverStance : std::uint8_t {
  kUpright,  ///< their z is up, as of plants
  kOnBed,    ///< their z is the bed's normal
  kTumbled,  ///< any rotation, as of stones
};

/// A closed interval; everything by default.
struct CoverRange {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool contains(double value) const { return low <= value && value <= high; }
};

/// Many small pieces of one kind that lie or grow on the terrain. The layer states how they are distributed; where each
/// piece is follows from the layer, its seed, the terrain and the solids, and from the density of all layers together,
/// by which the terrain is divided into tiles (cover_plan.h).
struct CoverLayer {
  std::string name;
  /// The shapes, of which each piece has one. Their origin lies on the bed, z up, and their largest extent is 1, so
  /// that a piece's size is its scale. They may be open, such as leaves; rays hit both sides.
  std::vector<TriangleMesh> meshes;
  CoverStance stance = CoverStance::kUpright;
  double sunk = 0;            ///< how deep a piece stands in the bed, as a fraction of its size
  double density_per_m2 = 1;  ///< where the layer grows
  CoverRange size_m{0.1, 0.1};
  /// The probability density of a size D is proportional to D^-(exponent + 1); the number of pieces larger than D of
  /// fragmented rock follows a power law (Turcotte 1986, J. Geophys. Res. 91(B2):1921). 0: log-uniform; -1: uniform.
  double size_exponent = 0;
  CoverRange depth_m;        ///< of the bed below z = 0
  CoverRange slope_rad;      ///< of the bed
  CoverRange from_solids_m;  ///< distance of the piece's origin from the nearest solid
  double patch_m = 0;        ///< size of the patches in which the layer grows; 0: everywhere
  double patch_share = 1;    ///< the share of the area that the patches take
  std::uint64_t seed = 0;
  bool solid = false;           ///< whether bodies touch the pieces
  double drag_coefficient = 0;  ///< of plants, on the frontal area of their meshes
  /// The speed of a steady current in which a piece leans by 45 degrees (Sway); infinite: pieces stand still.
  double leans_at_m_s = std::numeric_limits<double>::infinity();

  bool sways() const { return leans_at_m_s < std::numeric_limits<double>::infinity(); }
  /// Throws InvalidValue.
  void check() const;
};

}  // namespace uwsim
