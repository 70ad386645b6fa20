#pragma once

#include <gtest/gtest.h>

namespace vildar {

/// Studies run hundreds of passes: a matter of seconds optimised, of many minutes in a debug build.
class Study : public testing::Test {
 protected:
  void SetUp() override {
#ifndef NDEBUG
    GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  }
};

}  // namespace vildar
