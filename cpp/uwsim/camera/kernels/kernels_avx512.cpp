#include "uwsim/camera/kernels/kernel_table.h"

namespace uwsim::camera {

const Kernels& avx512_kernels() {
  static constexpr Kernels all = kernel_table("avx512");
  return all;
}

}  // namespace uwsim::camera
