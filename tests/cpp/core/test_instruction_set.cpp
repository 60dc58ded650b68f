#include <gtest/gtest.h>

#include "uwsim/core/instruction_set.h"

namespace uwsim {
namespace {

TEST(InstructionSet, AProcessorWithAWideSetHasTheNarrowerOnes) {
  EXPECT_TRUE(processor_has(InstructionSet::portable));
  EXPECT_TRUE(processor_has(InstructionSet::avx2) || !processor_has(InstructionSet::avx512));
}

TEST(InstructionSet, WidestReturnsTheTableForTheWidestSetOfTheProcessor) {
  const int tables[] = {0, 1, 2};
  const int expected = processor_has(InstructionSet::avx512) ? 2 : (processor_has(InstructionSet::avx2) ? 1 : 0);
  EXPECT_EQ(widest(tables[0], tables[1], tables[2]), expected);
}

}  // namespace
}  // namespace uwsim
