#pragma once

#include <cstddef>

namespace ertbench::testing {

/// Calls of operator new by this program so far.
std::size_t allocations();

}  // namespace ertbench::testing
