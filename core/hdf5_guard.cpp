#include "core/hdf5_guard.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "core/checksum.h"

namespace ertbench {
namespace {

/// Above the largest expansion of a built-in filter, deflate's 1032.
constexpr double largest_expansion = 2000;
constexpr double free_bytes = 1 << 20;

/// Product of the extents, as a double because an integer may overflow.
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

/// Number of chunks of a complete dataset.
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

/// The cause and the reason of a library message, without the internal state and the line break
/// that it adds to errors of the operating system.
std::string in_brief(const std::string& message) {
  const std::string reason = "error message = '";
  const std::size_t what = message.find(": time = ");
  const std::size_t why = message.find(reason);
  if (what == std::string::npos || why == std::string::npos) return message;
  const std::size_t first = why + reason.size();
  return message.substr(0, what) + ": " + message.substr(first, message.find('\'', first) - first);
}

constexpr std::uint64_t bytes_at_a_time = 8 << 20;

[[noreturn]] void fail(const std::string& object) {
  throw std::runtime_error(object + ": cannot be read; the file is damaged or cut short");
}

void add_number(Checksum& checksum, std::uint64_t number) {
  checksum.add({reinterpret_cast<const char*>(&number), sizeof number});
}

/// Names of all datasets, sorted.
std::vector<std::string> datasets_of(hid_t file) {
  std::vector<std::string> names;
  const auto note = [](hid_t, const char* name, const auto* info, void* out) -> herr_t {
    if (info->type == H5O_TYPE_DATASET)
      static_cast<std::vector<std::string>*>(out)->push_back(name);
    return 0;
  };
  if (H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, note, &names, H5O_INFO_BASIC) < 0) fail("/");
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> attributes_of(hid_t file) {
  std::vector<std::string> names;
  const auto note = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->push_back(name);
    return 0;
  };
  if (H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &names) < 0) fail("/");
  std::sort(names.begin(), names.end());
  std::erase(names, "checksum");
  return names;
}

/// Adds class, size and extents; returns the extents.
std::vector<hsize_t> add_form(Checksum& checksum, const std::string& name, hid_t type,
                              hid_t space) {
  if (H5Sget_simple_extent_ndims(space) < 0 || H5Tis_variable_str(type) > 0 ||
      H5Tget_class(type) == H5T_VLEN) {
    fail(name);
  }
  std::vector<hsize_t> extent = extent_of(space);
  checksum.add(name + '\0');
  add_number(checksum, static_cast<std::uint64_t>(H5Tget_class(type)));
  add_number(checksum, H5Tget_size(type));
  for (const hsize_t one : extent) add_number(checksum, one);
  return extent;
}

void add_dataset(Checksum& checksum, hid_t file, const std::string& name) {
  const Hdf5Handle set(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.valid() || !why_not_read(set).empty()) fail(name);
  const Hdf5Handle type(H5Dget_type(set), H5Tclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  std::vector<hsize_t> block = add_form(checksum, name, type, space);
  if (block.empty()) block = {1};
  const hsize_t rows = block[0];
  std::uint64_t row_bytes = H5Tget_size(type);
  for (std::size_t i = 1; i < block.size(); ++i) row_bytes *= block[i];
  const std::uint64_t rows_at_a_time =
      std::max<std::uint64_t>(1, bytes_at_a_time / std::max<std::uint64_t>(1, row_bytes));
  const bool scalar = H5Sget_simple_extent_ndims(space) == 0;
  std::vector<hsize_t> start(block.size(), 0);
  std::string bytes;
  for (hsize_t first = 0; first < rows && row_bytes > 0; first += block[0]) {
    start[0] = first;
    block[0] = std::min<hsize_t>(rows_at_a_time, rows - first);
    bytes.resize(block[0] * row_bytes);
    const Hdf5Handle memory(H5Screate_simple(static_cast<int>(block.size()), block.data(), nullptr),
                            H5Sclose);
    if (!scalar && H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(),
                                       nullptr) < 0) {
      fail(name);
    }
    if (H5Dread(set, type, memory, space, H5P_DEFAULT, bytes.data()) < 0) fail(name);
    checksum.add(bytes);
  }
}

void add_attribute(Checksum& checksum, hid_t file, const std::string& name) {
  const Hdf5Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.valid()) fail("attribute \"" + name + "\"");
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
  add_form(checksum, name, type, space);
  std::string bytes(H5Aget_storage_size(attribute), '\0');
  if (H5Aread(attribute, type, bytes.data()) < 0) fail("attribute \"" + name + "\"");
  checksum.add(bytes);
}

}  // namespace

std::string hdf5_message() {
  std::string message;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
        auto& text = *static_cast<std::string*>(out);
        if (text.empty() && error->desc) text = error->desc;
        return 0;
      },
      &message);
  return message.empty() ? "" : " (HDF5: " + in_brief(message) + ")";
}

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

std::string checksum_of_contents(std::int64_t file) {
  Checksum checksum;
  for (const std::string& name : datasets_of(file)) add_dataset(checksum, file, name);
  for (const std::string& name : attributes_of(file)) add_attribute(checksum, file, name);
  return checksum.text();
}

}  // namespace ertbench
