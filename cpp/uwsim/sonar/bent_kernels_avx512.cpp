#include "uwsim/sonar/bent_kernels_impl.h"

namespace uwsim {

const BentKernels& avx512_bent_kernels() { return kKernels; }

}  // namespace uwsim
