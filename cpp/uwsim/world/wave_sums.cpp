#include "uwsim/world/wave_sums.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/world/wave_sums_impl.h"

namespace uwsim {

const WaveSumKernels& baseline_wave_sum_kernels() { return kSumKernels; }
#if !UWSIM_X86
const WaveSumKernels& avx2_wave_sum_kernels() { return kSumKernels; }
const WaveSumKernels& avx512_wave_sum_kernels() { return kSumKernels; }
#endif

const WaveSumKernels& wave_sum_kernels() {
  return widest(baseline_wave_sum_kernels(), avx2_wave_sum_kernels(), avx512_wave_sum_kernels());
}

}  // namespace uwsim
