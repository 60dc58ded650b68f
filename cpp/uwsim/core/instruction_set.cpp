#include "uwsim/core/instruction_set.h"

namespace uwsim {
namespace {

bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
         __builtin_cpu_supports("popcnt");
}

bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}

}  // namespace

bool processor_has(InstructionSet set) {
  static const bool avx2 = has_avx2(), avx512 = has_avx512();
  if (set == InstructionSet::avx512) return avx512;
  return set != InstructionSet::avx2 || avx2;
}

InstructionSet widest_instruction_set() {
  if (processor_has(InstructionSet::avx512)) return InstructionSet::avx512;
  return processor_has(InstructionSet::avx2) ? InstructionSet::avx2 : InstructionSet::portable;
}

}  // namespace uwsim
