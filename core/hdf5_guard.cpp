#include "core/hdf5_guard.h"

#include <hdf5.h>

#include <vector>

#include "core/hdf5_handle.h"

namespace ertbench {
namespace {

/// No filter of the library's own makes more of a byte than deflate, 1032 times as many.
constexpr double largest_expansion = 2000;
constexpr double free_bytes = 1 << 20;

/// The product of the extents, as a double: no overflow.
double count_of(const std::vector<hsize_t>& extent) {
  double count = 1;
  for (const hsize_t one : extent) count *= static_cast<double>(one);
  return count;
}

std::vector<hsize_t> extent_of(hid_t space) {
  const int rank = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank < 0 ? 0 : rank));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  return extent;
}

/// Chunks that a whole dataset has.
double chunks_of(hid_t properties, const std::vector<hsize_t>& extent) {
  std::vector<hsize_t> chunk(extent.size());
  H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  double chunks = 1;
  for (std::size_t i = 0; i < extent.size(); ++i) {
    if (chunk[i] == 0) return 0;
    chunks *= static_cast<double>(extent[i] / chunk[i] + (extent[i] % chunk[i] != 0 ? 1 : 0));
  }
  return chunks;
}

}  // namespace

void forbid_foreign_hdf5() {
  H5Lunregister(H5L_TYPE_EXTERNAL);
  H5PLset_loading_state(0);
}

std::string why_not_read(std::int64_t dataset) {
  const Hdf5Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  if (!properties.valid() || !type.valid() || !space.valid())
    return "is damaged; write the file again";
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (layout == H5D_VIRTUAL || H5Pget_external_count(properties) > 0) {
    return "keeps its values in other files, which are not read; copy them into this one";
  }
  const std::vector<hsize_t> extent = extent_of(space);
  const double declared = count_of(extent) * static_cast<double>(H5Tget_size(type));
  const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
  bool all = layout == H5D_COMPACT || declared <= stored;
  if (layout == H5D_CHUNKED) {
    hsize_t chunks = 0;
    const bool counted = H5Dget_num_chunks(dataset, space, &chunks) >= 0;
    all = counted && static_cast<double>(chunks) >= chunks_of(properties, extent) &&
          declared <= largest_expansion * stored + free_bytes;
  }
  return all ? "" : "declares more values than the file holds; it is damaged, or not finished";
}

}  // namespace ertbench
