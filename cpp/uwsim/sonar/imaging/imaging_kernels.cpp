#include "uwsim/sonar/imaging/imaging_kernels.h"

#include "uwsim/core/instruction_set.h"
#include "uwsim/sonar/imaging/imaging_kernels_impl.h"

namespace uwsim {

const ImagingKernels& baseline_imaging_kernels() { return kKernels; }

const ImagingKernels& imaging_kernels() {
  return widest(baseline_imaging_kernels(), avx2_imaging_kernels(), avx512_imaging_kernels());
}

}  // namespace uwsim
