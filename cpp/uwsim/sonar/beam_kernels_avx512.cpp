#include "uwsim/sonar/beam_kernels_impl.h"

namespace uwsim {

const BeamKernels& avx512_beam_kernels() { return kKernels; }

}  // namespace uwsim
