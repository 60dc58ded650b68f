#include "uwsim/sonar/imaging/imaging_kernels_impl.h"

namespace uwsim {

const ImagingKernels& avx512_imaging_kernels() { return kKernels; }

}  // namespace uwsim
