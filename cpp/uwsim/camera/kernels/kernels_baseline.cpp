#include "uwsim/camera/kernels/kernel_table.h"
#include "uwsim/core/instruction_set.h"

namespace uwsim::camera {

const Kernels& baseline_kernels() {
  static constexpr Kernels all = kernel_table("baseline");
  return all;
}
#if !UWSIM_X86
const Kernels& avx2_kernels() { return baseline_kernels(); }
const Kernels& avx512_kernels() { return baseline_kernels(); }
#endif

const Kernels& kernels() { return widest(baseline_kernels(), avx2_kernels(), avx512_kernels()); }

}  // namespace uwsim::camera
