#pragma once

#include "uwsim/core/double_lanes.h"
#include "uwsim/vehicle/cut_kernels.h"

// Compiled once for each instruction set, hence the anonymous namespace. The loops are written for auto-vectorisation.
namespace uwsim {
namespace {

enum class Side { dry, cut, wet };

/// The side of the plane on which a block's triangles lie, if all lie on the same side.
inline Side side_of(const CutBlock& block, double ux, double uy, double uz, double level_m) {
  IndexLanes any{}, all = ~IndexLanes{};
  for (std::size_t lane = 0; lane < kCutLanes; lane += kLanes) {
    for (int corner = 0; corner < 3; ++corner) {
      const double(*const at)[kCutLanes] = block.corner_m + 3 * corner;
      const DoubleLanes height =
          ux * load_lanes(at[0] + lane) + uy * load_lanes(at[1] + lane) + uz * load_lanes(at[2] + lane) - level_m;
      const IndexLanes is_wet = height < 0;
      any |= is_wet;
      all &= is_wet;
    }
  }
  if (!any_of(any)) return Side::dry;
  return any_of(~all) ? Side::cut : Side::wet;
}

/// The contribution of one tetrahedron from the origin to r r^T, without the factor volume / 20: a_i a_j + b_i b_j +
/// c_i c_j + s_i s_j where s = a + b + c.
inline double product_sum(double ai, double bi, double ci, double aj, double bj, double cj) {
  return ai * aj + bi * bj + ci * cj + (ai + bi + ci) * (aj + bj + cj);
}

/// Adds the same as add_cut, to the last bit, for triangles that are all below the plane.
template <bool kWithSecond>
void add_wet(const CutBlock& block, CutSums& sums) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < kCutLanes; ++k) {
    const double ax = block.corner_m[0][k], ay = block.corner_m[1][k], az = block.corner_m[2][k];
    const double bx = block.corner_m[3][k], by = block.corner_m[4][k], bz = block.corner_m[5][k];
    const double cx = block.corner_m[6][k], cy = block.corner_m[7][k], cz = block.corner_m[8][k];
    const double volume = block.volume_m3[k];
    sums.volume_m3[k] += volume;
    sums.first_m4[0][k] += 0.25 * (volume * (ax + bx + cx));
    sums.first_m4[1][k] += 0.25 * (volume * (ay + by + cy));
    sums.first_m4[2][k] += 0.25 * (volume * (az + bz + cz));
    if constexpr (kWithSecond) {
      sums.second_m5[0][k] += 0.05 * (volume * product_sum(ax, bx, cx, ax, bx, cx));
      sums.second_m5[1][k] += 0.05 * (volume * product_sum(ay, by, cy, ay, by, cy));
      sums.second_m5[2][k] += 0.05 * (volume * product_sum(az, bz, cz, az, bz, cz));
      sums.second_m5[3][k] += 0.05 * (volume * product_sum(ax, bx, cx, ay, by, cy));
      sums.second_m5[4][k] += 0.05 * (volume * product_sum(ay, by, cy, az, bz, cz));
      sums.second_m5[5][k] += 0.05 * (volume * product_sum(az, bz, cz, ax, bx, cx));
    }
  }
}

/// A triangle with two wet corners is counted as fully wet, and the piece at its dry corner is subtracted; the piece at
/// a single wet corner is added. The piece is the triangle's tetrahedron, with the two edges at the odd corner o
/// shortened to the points p and q where they pierce the plane. Masks are the numbers 0 or 1, which avoids branches.
template <bool kWithSecond, bool kWithFace>
void add_cut(const CutBlock* blocks, std::size_t count, const double* up, double level_m, CutSums& sums,
             [[maybe_unused]] FaceSums* of_face) {
  const double ux = up[0], uy = up[1], uz = up[2];
  const double fx = level_m * ux, fy = level_m * uy, fz = level_m * uz;  // the foot of the origin
  for (std::size_t n = 0; n < count; ++n) {
    const CutBlock& block = blocks[n];
    const Side side = side_of(block, ux, uy, uz, level_m);
    if (side == Side::dry) continue;
    if (side == Side::wet) {
      add_wet<kWithSecond>(block, sums);
      continue;
    }
#pragma GCC ivdep
    for (std::size_t k = 0; k < kCutLanes; ++k) {
      const double ax = block.corner_m[0][k], ay = block.corner_m[1][k], az = block.corner_m[2][k];
      const double bx = block.corner_m[3][k], by = block.corner_m[4][k], bz = block.corner_m[5][k];
      const double cx = block.corner_m[6][k], cy = block.corner_m[7][k], cz = block.corner_m[8][k];
      const double volume = block.volume_m3[k];
      const double ha = ux * ax + uy * ay + uz * az - level_m;
      const double hb = ux * bx + uy * by + uz * bz - level_m;
      const double hc = ux * cx + uy * cy + uz * cz - level_m;
      const double wet_a = ha < 0 ? 1.0 : 0.0, wet_b = hb < 0 ? 1.0 : 0.0, wet_c = hc < 0 ? 1.0 : 0.0;
      const double wet = wet_a + wet_b + wet_c;
      const bool two = wet > 1.5;
      const double counts = two ? volume : 0.0;
      const double odd = two ? 0.0 : 1.0;  // 1 if the odd corner is wet, else 0
      const bool first = wet_a == odd, second = wet_b == odd;
      const bool cut = (wet > 0.5) & (wet < 2.5);

      const double ox = first ? ax : second ? bx : cx, px = first ? bx : second ? cx : ax;
      const double oy = first ? ay : second ? by : cy, py = first ? by : second ? cy : ay;
      const double oz = first ? az : second ? bz : cz, pz = first ? bz : second ? cz : az;
      const double qx = first ? cx : second ? ax : bx, ho = first ? ha : second ? hb : hc;
      const double qy = first ? cy : second ? ay : by, hp = first ? hb : second ? hc : ha;
      const double qz = first ? cz : second ? az : bz, hq = first ? hc : second ? ha : hb;
      const double to_p = cut ? ho / (ho - hp) : 0.0, to_q = cut ? ho / (ho - hq) : 0.0;
      const double x0 = ox + to_p * (px - ox), x1 = ox + to_q * (qx - ox);
      const double y0 = oy + to_p * (py - oy), y1 = oy + to_q * (qy - oy);
      const double z0 = oz + to_p * (pz - oz), z1 = oz + to_q * (qz - oz);
      const double sign = two ? -1.0 : 1.0;
      const double piece = sign * (to_p * to_q * volume);
      // Volume of the tetrahedron (origin, foot, q, p): up . (q x p) times the foot's distance over 6.
      const double area = ux * (z0 * y1 - y0 * z1) + uy * (x0 * z1 - z0 * x1) + uz * (y0 * x1 - x0 * y1);
      const double face = sign * (level_m / 6) * area;
      sums.volume_m3[k] += counts + (piece + face);
      const double sx = x0 + x1, sy = y0 + y1, sz = z0 + z1;
      sums.first_m4[0][k] += 0.25 * (counts * (ax + bx + cx) + (piece * (ox + sx) + face * (fx + sx)));
      sums.first_m4[1][k] += 0.25 * (counts * (ay + by + cy) + (piece * (oy + sy) + face * (fy + sy)));
      sums.first_m4[2][k] += 0.25 * (counts * (az + bz + cz) + (piece * (oz + sz) + face * (fz + sz)));
      if constexpr (kWithSecond) {
        const auto second_moment = [&](double ai, double bi, double ci, double oi, double i0, double i1, double fi,
                                       double aj, double bj, double cj, double oj, double j0, double j1, double fj) {
          return 0.05 * (counts * product_sum(ai, bi, ci, aj, bj, cj) +
                         (piece * product_sum(oi, i0, i1, oj, j0, j1) + face * product_sum(fi, i0, i1, fj, j0, j1)));
        };
        sums.second_m5[0][k] += second_moment(ax, bx, cx, ox, x0, x1, fx, ax, bx, cx, ox, x0, x1, fx);
        sums.second_m5[1][k] += second_moment(ay, by, cy, oy, y0, y1, fy, ay, by, cy, oy, y0, y1, fy);
        sums.second_m5[2][k] += second_moment(az, bz, cz, oz, z0, z1, fz, az, bz, cz, oz, z0, z1, fz);
        sums.second_m5[3][k] += second_moment(ax, bx, cx, ox, x0, x1, fx, ay, by, cy, oy, y0, y1, fy);
        sums.second_m5[4][k] += second_moment(ay, by, cy, oy, y0, y1, fy, az, bz, cz, oz, z0, z1, fz);
        sums.second_m5[5][k] += second_moment(az, bz, cz, oz, z0, z1, fz, ax, bx, cx, ox, x0, x1, fx);
      }
      if constexpr (kWithFace) {
        const double weight = sign * area;
        of_face->zeroth_m2[k] += weight;
        of_face->first_m3[0][k] += weight * sx;
        of_face->first_m3[1][k] += weight * sy;
        of_face->first_m3[2][k] += weight * sz;
        of_face->second_m4[0][k] += weight * (x0 * x0 + x1 * x1 + sx * sx);
        of_face->second_m4[1][k] += weight * (y0 * y0 + y1 * y1 + sy * sy);
        of_face->second_m4[2][k] += weight * (z0 * z0 + z1 * z1 + sz * sz);
        of_face->second_m4[3][k] += weight * (x0 * y0 + x1 * y1 + sx * sy);
        of_face->second_m4[4][k] += weight * (y0 * z0 + y1 * z1 + sy * sz);
        of_face->second_m4[5][k] += weight * (z0 * x0 + z1 * x1 + sz * sx);
      }
    }
  }
}

constexpr CutKernels kKernels = {add_cut<false, false>, add_cut<true, false>, add_cut<true, true>};

}  // namespace
}  // namespace uwsim
