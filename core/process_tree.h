#pragma once

#include <sys/types.h>

#include <cstdint>
#include <vector>

namespace ertbench {

/// The children of a process that have not been waited for, zombies among them.
std::vector<pid_t> children_of(pid_t process);

/// The resident memory of all descendants of a process together. Pages that several of them share
/// count for each.
std::uint64_t resident_bytes_below(pid_t process);

}  // namespace ertbench
