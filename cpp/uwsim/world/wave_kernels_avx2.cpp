#include "uwsim/world/wave_kernels_impl.h"

namespace uwsim {

const WaveKernels& avx2_wave_kernels() { return kKernels; }

}  // namespace uwsim
