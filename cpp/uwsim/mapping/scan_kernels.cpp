#include "uwsim/mapping/scan_kernels.h"

#include "uwsim/core/check.h"

namespace uwsim {

const bricks::Kernels& kernels_for(InstructionSet set) {
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  require(set != InstructionSet::avx2 || avx2, "map.instruction_set", "avx2", "this processor does not know it");
  require(set != InstructionSet::avx512 || avx512, "map.instruction_set", "avx512", "this processor does not know it");
  if (set == InstructionSet::avx512 || (set == InstructionSet::best && avx512)) return bricks::kAvx512Kernels;
  if (set == InstructionSet::avx2 || (set == InstructionSet::best && avx2)) return bricks::kAvx2Kernels;
  return bricks::kPortableKernels;
}

}  // namespace uwsim
