#pragma once

#include <cstdint>
#include <string>

namespace ertbench {

/// Keeps the HDF5 library from following links to other files and from loading filters as plugins,
/// for this whole process. Called before anything else of the library.
void forbid_foreign_hdf5();

/// Why the values of an opened dataset are not read: they are in other files, or fewer than the
/// dataset declares, so that reading would make up for what nobody stored; empty where they are.
/// `dataset`: the library's identifier.
std::string why_not_read(std::int64_t dataset);

}  // namespace ertbench
