#include "uwsim/world/wave_sums_impl.h"

namespace uwsim {

const WaveSumKernels& avx2_wave_sum_kernels() { return kSumKernels; }

}  // namespace uwsim
