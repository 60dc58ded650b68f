#include "uwsim/vehicle/cut_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/vehicle/cut_kernels_impl.h"

namespace uwsim {

const CutKernels& baseline_cut_kernels() { return kKernels; }
#if !UWSIM_X86
const CutKernels& avx2_cut_kernels() { return kKernels; }
const CutKernels& avx512_cut_kernels() { return kKernels; }
#endif

const CutKernels& cut_kernels() { return widest(baseline_cut_kernels(), avx2_cut_kernels(), avx512_cut_kernels()); }

}  // namespace uwsim
