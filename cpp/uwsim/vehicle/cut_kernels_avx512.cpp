#include "uwsim/vehicle/cut_kernels_impl.h"

namespace uwsim {

const CutKernels& avx512_cut_kernels() { return kKernels; }

}  // namespace uwsim
