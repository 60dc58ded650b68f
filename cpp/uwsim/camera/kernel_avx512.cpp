#include "uwsim/camera/kernel_table.h"

namespace uwsim::camera {

const Kernels* avx512_kernels() {
  static constexpr Kernels all = table("avx512");
  return &all;
}

}  // namespace uwsim::camera
