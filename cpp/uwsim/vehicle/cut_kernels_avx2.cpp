#include "uwsim/vehicle/cut_kernels_impl.h"

namespace uwsim {

const CutKernels& avx2_cut_kernels() { return kKernels; }

}  // namespace uwsim
