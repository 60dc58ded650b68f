#include "uwsim/camera/kernel_table.h"

namespace uwsim::camera {

const Kernels& baseline_kernels() {
  static constexpr Kernels all = table("baseline");
  return all;
}

const Kernels& kernels() {
  static const Kernels& fastest = []() -> const Kernels& {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && avx512_kernels()) {
      return *avx512_kernels();
    }
    if (__builtin_cpu_supports("avx2") && avx2_kernels()) return *avx2_kernels();
    return baseline_kernels();
  }();
  return fastest;
}

}  // namespace uwsim::camera
