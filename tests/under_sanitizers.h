#pragma once

#include <gtest/gtest.h>

/// For tests of numbers alone that take minutes under the sanitizers and go no other way through
/// the memory than shorter ones: once, in the release, is enough.
#ifdef __SANITIZE_ADDRESS__
#define ERTBENCH_NOT_UNDER_SANITIZERS() GTEST_SKIP() << "takes minutes under the sanitizers"
#else
#define ERTBENCH_NOT_UNDER_SANITIZERS() static_cast<void>(0)
#endif
