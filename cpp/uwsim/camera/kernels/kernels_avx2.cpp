#include "uwsim/camera/kernels/kernel_table.h"

namespace uwsim::camera {

const Kernels& avx2_kernels() {
  static constexpr Kernels all = kernel_table("avx2");
  return all;
}

}  // namespace uwsim::camera
