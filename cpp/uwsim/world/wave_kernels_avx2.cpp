#include "uwsim/world/wave_kernels_impl.h"
#include "uwsim/world/wave_sums_impl.h"

namespace uwsim {

const WaveKernels& avx2_wave_kernels() { return kKernels; }
const WaveSumKernels& avx2_wave_sum_kernels() { return kSumKernels; }

}  // namespace uwsim
