#include "uwsim/world/wave_kernels_impl.h"
#include "uwsim/world/wave_sums_impl.h"

namespace uwsim {

const WaveKernels& avx512_wave_kernels() { return kKernels; }
const WaveSumKernels& avx512_wave_sum_kernels() { return kSumKernels; }

}  // namespace uwsim
