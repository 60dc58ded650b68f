#include "uwsim/mapping/bricks/kernels/scan_kernels.h"

#include "uwsim/core/check.h"

namespace uwsim {

const bricks::Kernels& kernels_for(InstructionSet set) {
  if (set == InstructionSet::best) set = widest_instruction_set();
  const char* const name = set == InstructionSet::avx512 ? "avx512" : "avx2";
  require(processor_has(set), "map.instruction_set", name, "this processor does not have it");
#if UWSIM_X86
  if (set == InstructionSet::avx512) return bricks::kAvx512Kernels;
  if (set == InstructionSet::avx2) return bricks::kAvx2Kernels;
#endif
  return bricks::kPortableKernels;
}

}  // namespace uwsim
