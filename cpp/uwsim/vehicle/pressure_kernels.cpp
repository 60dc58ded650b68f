#include "uwsim/vehicle/pressure_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/vehicle/pressure_kernels_impl.h"

namespace uwsim {

const PressureKernels& baseline_pressure_kernels() { return kKernels; }

const PressureKernels& pressure_kernels() {
  return widest(baseline_pressure_kernels(), avx2_pressure_kernels(), avx512_pressure_kernels());
}

}  // namespace uwsim
