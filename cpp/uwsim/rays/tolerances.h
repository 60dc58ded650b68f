#pragma once

namespace uwsim {

// Every tolerance, margin and error bound of the ray engine; README.md contains the resulting error budget. Because
// kernels include this file, it only defines constants and declares one function.

/// The sine of 0.1 degree, rounded down. At smaller angles to a surface, float's error may decide whether a ray grazes
/// or misses it; errors that grow with 1 / sine are covered only down to this angle.
inline constexpr double kGrazingSine = 1.7e-3;

// Tolerances for float.

/// A bound on how far a point of a tile moves when it is rounded to float relative to the tile's middle, as a fraction
/// of half the tile's diagonal. One rounding moves a coordinate by up to 2^-24 = 6e-8 of that; the bound allows for 16
/// roundings, since vertices, origins, directions and Embree's own arithmetic each contribute.
inline constexpr double kFloatError = 1e-6;
/// Lower limit of that bound, which applies to tiles of a few millimetres or less.
inline constexpr double kLeastFloatError_m = 1e-8;
/// The relative extension of a float ray beyond the ray in double, so that rounding does not cut it short; hits beyond
/// the ray's end are discarded in double.
inline constexpr double kFartherRelative = 1e-6;
inline constexpr double kFarther_m = 1e-6;
/// For the same reason, a search for the nearest triangle reaches farther than the best distance so far, by this
/// fraction.
inline constexpr double kFartherSearch = 1e-5;
/// If terrain is raised by less than this, shadow rays need no second check, because they start at least 1 mm off the
/// surface that they leave.
inline constexpr double kHarmlessRaise_m = 5e-4;
/// A corner of a widened triangle moves by at most this multiple of the widening. Since 1 / 8 is the sine of half of 14
/// degrees, only corners sharper than 14 degrees are treated separately.
inline constexpr double kLongestMitre = 8;

// Tolerances for double.

/// In barycentric units: neighbouring triangles overlap by this much, so that no ray slips between them.
inline constexpr double kSeam = 1e-10;
/// In cells: a terrain hit computed in double is accepted immediately if it lies this far inside its triangle;
/// otherwise, a walk from cell to cell decides. The block over which the ray walks is wider by the same amount on each
/// side. At the far side of a terrain of 10,000 cells, the rounding error in double is 1e-12 cells.
inline constexpr double kCellMargin = 1e-9;
/// A ray misses a round shape if the squared distance of its line exceeds the squared radius by more than this
/// fraction.
inline constexpr double kRoundMargin = 1e-9;

/// The tolerances of one tile [m]. They follow from rounding_m and from the terrain's steepest triangle.
struct Tolerances {
  /// A bound on how far float rounding moves any point of a ray or a surface in this tile: `kFloatError` times half the
  /// tile's diagonal. Called r below. 0.3 mm in a square tile of 400 m, 0.7 mm in one of 1 km.
  double rounding_m;

  /// 8 r: the distance, perpendicular to the ray, between the point reported by Embree and the true hit.
  double hit_error_m;

  /// 64 r: how far the edges of a solid's triangles are moved outward for Embree. In the plane of the surface, an error
  /// perpendicular to a ray is amplified by 1 / sine, which is 570 at 0.1 degree. The error of one rounding, r / 16,
  /// thus becomes 36 r.
  double widening_m;

  /// 256 r, or 0 if no solid has triangles: the distance before its origin at which a float ray starts. In float, a
  /// triangle just ahead of the origin may end up behind it, by 1 / sine times the perpendicular error.
  double setback_m;

  /// r / 2, or 8 roundings: how far the terrain is raised for Embree, measured perpendicularly to the steepest triangle
  /// at each vertex.
  double raise_m;

  /// `raise_m` times `steepest`, which is 1 / cosine of the steepest slope in the tile: the raise measured vertically.
  double upward_raise_m;

  /// 4 `upward_raise_m`: a point this far above the terrain is also above the raised terrain. The first raise applies
  /// to all vertices. Vertices at a block's edges also move outward by one raise along each axis and, to compensate,
  /// rise by up to two more raises. The fourth raise allows for rounding.
  double clearance_m;

  /// 4 r + `clearance_m`: how much farther from a point Embree's surfaces may be than the true ones.
  double search_margin_m;

  /// 16 r + `clearance_m`: if a terrain cell and a solid are closer together than this, a cast in float may hit them in
  /// the wrong order.
  double near_terrain_m;

  /// 8 r: if triangles or shapes of solids are closer together than this, a cast in float may hit them in the wrong
  /// order.
  double crowding_m;

  /// r: a hit this far inside a triangle's edges is on that triangle, regardless of what float reports.
  double edge_margin_m;

  /// 2 r: added to the bounding boxes of round shapes.
  double round_box_margin_m;

  /// 16 widenings: added to the tile's bounding box, so that it encloses all of the above.
  double box_margin_m;

  /// The distance along the ray between the point reported by Embree and the true hit, for a given sine of the angle
  /// between ray and surface: the error perpendicular to the ray, plus its effect along the surface.
  double hit_error_along_m(double sine) const { return hit_error_m * (1 + 1 / sine); }

  /// The largest distance outside the true triangle at which a float ray's hit on the widened triangle is accepted.
  /// Float's error along a ray grows with the ray's length over the triangle. Only a twentieth of the bound is used, so
  /// that the tips of slivers do not grow.
  double picture_edge_m(double sine) const { return hit_error_m * (1 + 0.05 / sine); }
};

/// Computes the tolerances of a tile. diagonal_m: the diagonal of its surfaces' bounding box. steepest: 1 / cosine of
/// the terrain's steepest slope (1 without terrain). has_solid_triangles: whether rays can hit triangles of solids in
/// the tile.
Tolerances tolerances_of(double diagonal_m, double steepest, bool has_solid_triangles);

}  // namespace uwsim
