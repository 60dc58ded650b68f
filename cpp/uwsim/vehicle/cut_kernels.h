#pragma once

#include <cstddef>

namespace uwsim {

inline constexpr std::size_t kCutLanes = 8;

/// Eight triangles that a plane may cut, one array per value. Unused slots are 0.
struct alignas(64) CutBlock {
  double corner_m[9][kCutLanes];  ///< x, y, z of the first corner, then of the second and third
  double volume_m3[kCutLanes];    ///< of the tetrahedra from the origin, signed
};

/// The integrals of 1, r and r r^T over a volume, as eight partial sums each.
struct alignas(64) CutSums {
  double volume_m3[kCutLanes];
  double first_m4[3][kCutLanes];
  double second_m5[6][kCutLanes];  ///< xx, yy, zz, xy, yz, zx
};

/// Over the face that a plane cuts: the sums of w, w (p + q) and w (p p^T + q q^T + (p + q) (p + q)^T) over its edges
/// p q, where w is twice the area of the triangle from the foot of the origin on the plane to the edge.
struct alignas(64) FaceSums {
  double zeroth_m2[kCutLanes];
  double first_m3[3][kCutLanes];
  double second_m4[6][kCutLanes];  ///< as in CutSums
};

/// The loop over triangles at a plane, compiled for each instruction set. All versions produce the same bits.
///
/// `add` adds the contributions of the triangles to the volume up . r < level_m: their tetrahedra from the origin, each
/// cut at the plane, and their parts of the cut face, which are triangles from the foot of the origin on the plane to
/// the edges of the cut. `add_with_second` adds the second moments as well, and `add_with_face` the face's sums
/// besides; only it uses `face`.
struct CutKernels {
  using Add = void (*)(const CutBlock* blocks, std::size_t count, const double* up, double level_m, CutSums& sums,
                       FaceSums* face);
  Add add, add_with_second, add_with_face;
};

const CutKernels& baseline_cut_kernels();
const CutKernels& avx2_cut_kernels();
const CutKernels& avx512_cut_kernels();
/// The kernels for the widest instruction set that this processor supports.
const CutKernels& cut_kernels();

}  // namespace uwsim
