#include "uwsim/vehicle/pressure_kernels_impl.h"

namespace uwsim {

const PressureKernels& avx2_pressure_kernels() { return kKernels; }

}  // namespace uwsim
