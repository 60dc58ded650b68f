#include "uwsim/rays/ray_kernels_impl.h"

namespace uwsim {

const RayKernels& avx2_ray_kernels() { return kKernels; }

}  // namespace uwsim
