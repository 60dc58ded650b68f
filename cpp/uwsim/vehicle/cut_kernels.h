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

/// The loop over triangles at a plane, compiled for each instruction set. All versions produce the same bits.
///
/// `add` adds the contributions of the triangles to the volume up . r < level_m: their tetrahedra from the origin, each
/// cut at the plane, and their parts of the cut face, which are triangles from the foot of the origin on the plane to
/// the edges of the cut. `add_with_second` adds the second moments as well.
struct CutKernels {
  using Add = void (*)(const CutBlock* blocks, std::size_t count, const double* up, double level_m, CutSums& sums);
  Add add, add_with_second;
};

const CutKernels& baseline_cut_kernels();
const CutKernels& avx2_cut_kernels();
const CutKernels& avx512_cut_kernels();
/// The kernels for the widest instruction set that this processor supports.
const CutKernels& cut_kernels();

}  // namespace uwsim
