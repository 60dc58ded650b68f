#include "uwsim/sonar/beam_kernels.h"

#include "uwsim/sonar/beam_kernels_impl.h"

namespace uwsim {

const BeamKernels& baseline_beam_kernels() { return kKernels; }

const BeamKernels& beam_kernels() {
  static const bool avx512 =
      __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  static const bool avx2 = __builtin_cpu_supports("avx2");
  return avx512 ? avx512_beam_kernels() : avx2 ? avx2_beam_kernels() : baseline_beam_kernels();
}

}  // namespace uwsim
