#include "uwsim/world/wave_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/world/wave_kernels_impl.h"

namespace uwsim {

const WaveKernels& baseline_wave_kernels() { return kKernels; }

const WaveKernels& wave_kernels() {
  return widest(baseline_wave_kernels(), avx2_wave_kernels(), avx512_wave_kernels());
}

}  // namespace uwsim
