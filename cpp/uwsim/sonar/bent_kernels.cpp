#include "uwsim/sonar/bent_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/sonar/bent_kernels_impl.h"

namespace uwsim {

const BentKernels& baseline_bent_kernels() { return kKernels; }
#if !UWSIM_X86
const BentKernels& avx2_bent_kernels() { return kKernels; }
const BentKernels& avx512_bent_kernels() { return kKernels; }
#endif

const BentKernels& bent_kernels() {
  return widest(baseline_bent_kernels(), avx2_bent_kernels(), avx512_bent_kernels());
}

}  // namespace uwsim
