// Tests that run on several ranks. Every rank runs every test; a failure on any rank fails the program (mpirun reports
// it).

#include <gtest/gtest.h>

#include "noiseloom/dist/communicator.h"

int main(int argc, char** argv) {
  const noiseloom::MpiSession session(argc, argv);
  testing::InitGoogleTest(&argc, argv);
  const bool is_root = noiseloom::Communicator::world().is_root();
  auto& listeners = testing::UnitTest::GetInstance()->listeners();
  if (!is_root) delete listeners.Release(listeners.default_result_printer());
  const int own = RUN_ALL_TESTS();
  const bool any = noiseloom::Communicator::world().any_bits(own != 0 ? 1U : 0U) != 0;
  return any ? 1 : 0;
}
