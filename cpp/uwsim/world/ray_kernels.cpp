#include "uwsim/world/ray_kernels.h"

#include "uwsim/world/ray_kernels_impl.h"

namespace uwsim {

const RayKernels& baseline_ray_kernels() { return kKernels; }

const RayKernels& ray_kernels() {
  static const bool avx512 =
      __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  static const bool avx2 = __builtin_cpu_supports("avx2");
  return avx512 ? avx512_ray_kernels() : avx2 ? avx2_ray_kernels() : baseline_ray_kernels();
}

}  // namespace uwsim
