#include "uwsim/core/instruction_set.h"

#include <cstdlib>
#include <string>

#include "uwsim/core/check.h"

namespace uwsim {
namespace {

#if UWSIM_X86
bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
         __builtin_cpu_supports("popcnt");
}

bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
bool has_avx2() { return false; }
bool has_avx512() { return false; }
#endif

InstructionSet widest_of_processor() {
  if (processor_has(InstructionSet::avx512)) return InstructionSet::avx512;
  return processor_has(InstructionSet::avx2) ? InstructionSet::avx2 : InstructionSet::portable;
}

InstructionSet chosen_set() {
  const char* const text = std::getenv("UWSIM_INSTRUCTION_SET");
  const std::string name = text ? text : "";
  if (name.empty()) return InstructionSet::best;
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512}) {
    if (name != instruction_set_name(set)) continue;
    require(processor_has(set), "UWSIM_INSTRUCTION_SET", name, "this processor does not have it");
    return set;
  }
  require(false, "UWSIM_INSTRUCTION_SET", name, "must be portable, avx2 or avx512");
  return InstructionSet::best;
}

}  // namespace

const char* instruction_set_name(InstructionSet set) {
  constexpr const char* kNames[] = {"best", "portable", "avx2", "avx512"};
  return kNames[static_cast<std::size_t>(set)];
}

bool processor_has(InstructionSet set) {
  static const bool avx2 = has_avx2(), avx512 = has_avx512();
  if (set == InstructionSet::avx512) return avx512;
  return set != InstructionSet::avx2 || avx2;
}

InstructionSet chosen_instruction_set() {
  static const InstructionSet chosen = chosen_set();
  return chosen;
}

InstructionSet widest_instruction_set() {
  const InstructionSet chosen = chosen_instruction_set();
  return chosen == InstructionSet::best ? widest_of_processor() : chosen;
}

}  // namespace uwsim
