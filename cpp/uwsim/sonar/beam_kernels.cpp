#include "uwsim/sonar/beam_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/sonar/beam_kernels_impl.h"

namespace uwsim {

const BeamKernels& baseline_beam_kernels() { return kKernels; }
#if !UWSIM_X86
const BeamKernels& avx2_beam_kernels() { return kKernels; }
const BeamKernels& avx512_beam_kernels() { return kKernels; }
#endif

const BeamKernels& beam_kernels() {
  return widest(baseline_beam_kernels(), avx2_beam_kernels(), avx512_beam_kernels());
}

}  // namespace uwsim
