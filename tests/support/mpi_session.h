// MPI for a test program that gtest_main starts.
#pragma once

#include <gtest/gtest.h>

#if defined(NOISELOOM_SANITIZE_ADDRESS)
#include <sanitizer/lsan_interface.h>
#endif

#include <memory>

#include "noiseloom/dist/communicator.h"

namespace noiseloom::testing_support {

class MpiEnvironment : public testing::Environment {
 public:
  void SetUp() override {
    const LeaksOfOthers allowed;
    int argc = 0;
    char** argv = nullptr;
    session_ = std::make_unique<MpiSession>(argc, argv);
  }
  void TearDown() override {
    const LeaksOfOthers allowed;
    session_.reset();
  }

 private:
  // Open MPI itself never frees what it has at the end.
  struct LeaksOfOthers {
#if defined(NOISELOOM_SANITIZE_ADDRESS)
    __lsan::ScopedDisabler disabler = {};
#endif
    ~LeaksOfOthers() {}
  };
  std::unique_ptr<MpiSession> session_;
};
inline const testing::Environment* const mpi_environment = testing::AddGlobalTestEnvironment(new MpiEnvironment);

}  // namespace noiseloom::testing_support
