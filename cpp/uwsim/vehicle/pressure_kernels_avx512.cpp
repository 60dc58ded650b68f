#include "uwsim/vehicle/pressure_kernels_impl.h"

namespace uwsim {

const PressureKernels& avx512_pressure_kernels() { return kKernels; }

}  // namespace uwsim
