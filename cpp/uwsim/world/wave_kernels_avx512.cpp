#include "uwsim/world/wave_kernels_impl.h"

namespace uwsim {

const WaveKernels& avx512_wave_kernels() { return kKernels; }

}  // namespace uwsim
