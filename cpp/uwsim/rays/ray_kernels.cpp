#include "uwsim/rays/ray_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/rays/ray_kernels_impl.h"

namespace uwsim {

const RayKernels& baseline_ray_kernels() { return kKernels; }
#if !UWSIM_X86
const RayKernels& avx2_ray_kernels() { return kKernels; }
const RayKernels& avx512_ray_kernels() { return kKernels; }
#endif

const RayKernels& ray_kernels() { return widest(baseline_ray_kernels(), avx2_ray_kernels(), avx512_ray_kernels()); }

}  // namespace uwsim
