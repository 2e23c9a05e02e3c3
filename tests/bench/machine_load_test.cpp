#include <gtest/gtest.h>
#include <sched.h>

#include <future>

#include "bench/run/timing_stage.h"

namespace ertbench {
namespace {

TEST(UsableCores, AreThoseOfTheAffinity) {
  EXPECT_GE(usable_cores(), 1);
  const int on_one = std::async(std::launch::async, [] {
                       cpu_set_t set;
                       sched_getaffinity(0, sizeof set, &set);
                       int core = 0;
                       while (!CPU_ISSET(core, &set)) ++core;
                       CPU_ZERO(&set);
                       CPU_SET(core, &set);
                       sched_setaffinity(0, sizeof set, &set);  // of this thread alone
                       return usable_cores();
                     }).get();
  EXPECT_EQ(on_one, 1);
}

}  // namespace
}  // namespace ertbench
