#pragma once

#include <cstdint>
#include <string>

namespace ertbench {

/// A checksum of all that an open HDF5 file holds: names, types, shapes and values of its datasets
/// in all groups, and the root's attributes, but the attribute "checksum". How the values lie in
/// the file is no part of it. Throws std::runtime_error where the library cannot read something.
/// `file`: the library's identifier.
std::string checksum_of_contents(std::int64_t file);

}  // namespace ertbench
