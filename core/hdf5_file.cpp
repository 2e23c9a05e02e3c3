#include "core/hdf5_file.h"

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_guard.h"
#include "core/lists.h"

namespace ertbench {
namespace {

/// Called before anything else of the library.
void prepare_library() {
  // Files close with their owners; the library's own clean-up at the program's end crashes on what
  // a damaged file leaves behind.
  static const herr_t once = H5dont_atexit();
  static_cast<void>(once);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  forbid_foreign_hdf5();
}

/// Turns off the library's locking: it refuses readers on file systems without locks, and truncates
/// before it asks for the lock. Writers of datasets take a lock of their own (generate.cpp).
Hdf5Handle access_properties() {
  const hid_t properties = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_file_locking(properties, false, true);
  return {properties, H5Pclose};
}

/// Type of a UTF-8 string of the text's length, padded with zeros.
hid_t text_type(const std::string& text) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, std::max<std::size_t>(1, text.size()));
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

std::string dimensions(const std::vector<std::uint64_t>& shape, bool any = false) {
  const auto text = [&](std::uint64_t n) { return any && n == 0 ? "N" : std::to_string(n); };
  return "[" + joined(shape, ", ", text) + "]";
}

struct StorageType {
  hid_t type;
  const char* name;
};

StorageType storage_type(Hdf5File::Number number) {
  switch (number) {
    case Hdf5File::Number::uint8:
      return {H5T_STD_U8LE, "8-bit unsigned integers"};
    case Hdf5File::Number::real32:
      return {H5T_IEEE_F32LE, "32-bit real numbers"};
    case Hdf5File::Number::int64:
      return {H5T_STD_I64LE, "64-bit integers"};
    case Hdf5File::Number::real64:
      break;
  }
  return {H5T_IEEE_F64LE, "64-bit real numbers"};
}

/// Values in one row of a dataset.
std::uint64_t row_width(const std::vector<std::uint64_t>& shape) {
  return std::accumulate(shape.begin() + 1, shape.end(), std::uint64_t{1}, std::multiplies<>());
}

/// Selects the rows of `block` (extents, rows first) from row `first` of a dataset's space on.
bool select_rows(hid_t space, std::uint64_t first, const std::vector<hsize_t>& block) {
  std::vector<hsize_t> start(block.size(), 0);
  start[0] = first;
  return H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr) >=
         0;
}

/// Creates a scalar attribute; false if that fails. The bytes of `value` are those of `type`.
bool write_attribute(hid_t file, const std::string& object, const std::string& attribute,
                     hid_t type, const void* value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle a(H5Acreate_by_name(file, object.c_str(), attribute.c_str(), type, space,
                                       H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Aclose);
  return a.valid() && H5Awrite(a, type, value) >= 0;
}

const char* const not_written = "cannot be written; is the disk full?";
const char* const damaged = "cannot be read; the file is damaged or cut short";

}  // namespace

Hdf5File Hdf5File::open(const std::filesystem::path& file) {
  prepare_library();
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    throw InputError(file.string() + ": does not exist; check the name");
  }
  require_regular_file(file);
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, access_properties());
  if (id < 0) {
    throw InputError(file.string() +
                     ": cannot be opened as HDF5; it is another format, damaged or cut short" +
                     hdf5_message());
  }
  return Hdf5File(file, id);
}

Hdf5File Hdf5File::open_writable(const std::filesystem::path& file) {
  prepare_library();
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, access_properties());
  if (id < 0) {
    throw InputError(file.string() +
                     ": cannot be opened for writing; check that it is a file that may be "
                     "written, and that the disk has space" +
                     hdf5_message());
  }
  return Hdf5File(file, id);
}

Hdf5File Hdf5File::create(const std::filesystem::path& file) {
  prepare_library();
  const Hdf5Handle access = access_properties();  // closing it would clear the library's message
  const hid_t id = H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (id < 0) {
    throw InputError(file.string() +
                     ": cannot be created; check that the folder exists and is writable; is the "
                     "disk full?" +
                     hdf5_message());
  }
  return Hdf5File(file, id);
}

bool Hdf5File::holds(const std::filesystem::path& file, const std::string& object) {
  try {
    return open(file).has(object);
  } catch (const InputError&) {
    return false;
  }
}

Hdf5File::Hdf5File(Hdf5File&& other) noexcept : path_(std::move(other.path_)), id_(other.id_) {
  other.id_ = -1;
}

Hdf5File::~Hdf5File() {
  if (id_ >= 0) H5Fclose(id_);
}

void Hdf5File::fail(const std::string& object, const std::string& message) const {
  throw InputError(path_.string() + ": " + object + ": " + message);
}

bool Hdf5File::has(const std::string& object) const {
  return object == "/" || H5Lexists(id_, object.c_str(), H5P_DEFAULT) > 0;
}

bool Hdf5File::has_attribute(const std::string& object, const std::string& name) const {
  return H5Aexists_by_name(id_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5File::names(const std::string& group) const {
  if (!has(group)) return {};
  H5L_info_t link;
  const bool is_link = group != "/" && (H5Lget_info(id_, group.c_str(), &link, H5P_DEFAULT) < 0 ||
                                        link.type != H5L_TYPE_HARD);
  if (is_link) fail(group, "is a link to elsewhere");
  const Hdf5Handle opened(H5Gopen2(id_, group.c_str(), H5P_DEFAULT), H5Gclose);
  if (!opened.valid()) fail(group, "must be a group" + hdf5_message());
  struct Found {
    std::vector<std::string> names;
    std::string link;
  } found;
  const auto add = [](hid_t, const char* name, const H5L_info_t* info, void* out) -> herr_t {
    auto& all = *static_cast<Found*>(out);
    all.names.emplace_back(name);
    if (info->type == H5L_TYPE_HARD) return 0;
    all.link = name;
    return 1;
  };
  if (H5Literate(opened, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &found) < 0) {
    fail(group, damaged + hdf5_message());
  }
  if (!found.link.empty()) fail(group + "/" + found.link, "is a link to elsewhere");
  return found.names;
}

std::int64_t Hdf5File::open_dataset(const std::string& dataset) const {
  if (!has(dataset)) fail(dataset, "is missing");
  const hid_t set = H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT);
  if (set < 0) fail(dataset, "is not a readable dataset; write the file again" + hdf5_message());
  if (const std::string why = why_not_read(set); !why.empty()) {
    H5Dclose(set);
    fail(dataset, why);
  }
  return set;
}

std::vector<std::uint64_t> Hdf5File::shape(const std::string& dataset) const {
  const Hdf5Handle set(open_dataset(dataset), H5Dclose);
  const Hdf5Handle type(H5Dget_type(set), H5Tclose);
  if (!type.valid() || (H5Tget_class(type) != H5T_FLOAT && H5Tget_class(type) != H5T_INTEGER)) {
    fail(dataset, "must hold real numbers");
  }
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (!space.valid() || rank < 0 || rank > 8) fail(dataset, "has no simple shape");
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  return {extent.begin(), extent.end()};
}

std::vector<std::uint64_t> Hdf5File::require_shape(
    const std::string& dataset, const std::vector<std::uint64_t>& expected) const {
  std::vector<std::uint64_t> found = shape(dataset);
  bool same = found.size() == expected.size();
  for (std::size_t i = 0; same && i < found.size(); ++i) {
    same = expected[i] == 0 ? found[i] >= 1 : found[i] == expected[i];
  }
  if (!same) {
    fail(dataset, "must have shape " + dimensions(expected, true) + ", has " + dimensions(found));
  }
  return found;
}

RowMajorMatrix Hdf5File::read_rows(const std::string& dataset, std::uint64_t first,
                                   std::uint64_t count, bool allow_nan) const {
  const std::vector<std::uint64_t> extent = shape(dataset);
  if (extent.empty() || count > extent[0] || first > extent[0] - count) {
    fail(dataset, "has " + std::to_string(extent.empty() ? 0 : extent[0]) + " rows, asked for " +
                      std::to_string(first) + " to " + std::to_string(first + count));
  }
  const std::uint64_t width = row_width(extent);
  const Hdf5Handle set(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  RowMajorMatrix values(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(width));
  if (values.size() == 0) return values;
  std::vector<hsize_t> block(extent.begin(), extent.end());
  block[0] = count;
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  const Hdf5Handle memory(H5Screate_simple(static_cast<int>(block.size()), block.data(), nullptr),
                          H5Sclose);
  if (!select_rows(space, first, block) ||
      H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()) < 0) {
    fail(dataset, damaged + hdf5_message());
  }
  if (!allow_nan && !values.allFinite()) {
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      if (std::isfinite(values.data()[i])) continue;
      fail(dataset, "element " + std::to_string(static_cast<std::uint64_t>(i) % width) +
                        " of row " + std::to_string(first + static_cast<std::uint64_t>(i) / width) +
                        " is not a finite number; remove that row or mend its value");
    }
  }
  return values;
}

Eigen::VectorXd Hdf5File::read_vector(const std::string& dataset) const {
  const std::vector<std::uint64_t> extent = require_shape(dataset, {0});
  return read_rows(dataset, 0, extent[0]).col(0);
}

std::string Hdf5File::read_text(const std::string& object, const std::string& attribute) const {
  const Hdf5Handle a(
      H5Aopen_by_name(id_, object.c_str(), attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!a.valid()) fail(object, "attribute \"" + attribute + "\" is missing");
  const Hdf5Handle type(H5Aget_type(a), H5Tclose);
  const std::string wrong = "attribute \"" + attribute + "\" must be a string";
  if (!type.valid() || H5Tget_class(type) != H5T_STRING) fail(object, wrong);
  const Hdf5Handle space(H5Aget_space(a), H5Sclose);
  if (H5Sget_simple_extent_npoints(space) != 1) fail(object, wrong);
  std::string text;
  if (H5Tis_variable_str(type) > 0) {
    char* value = nullptr;
    const Hdf5Handle memory(H5Tget_native_type(type, H5T_DIR_ASCEND), H5Tclose);
    if (H5Aread(a, memory, &value) < 0 || !value) fail(object, wrong + hdf5_message());
    text = value;
    H5free_memory(value);
  } else {
    const std::size_t size = H5Tget_size(type);
    if (size > (std::size_t{1} << 26)) fail(object, wrong);
    text.resize(size);
    if (H5Aread(a, type, text.data()) < 0) fail(object, wrong + hdf5_message());
    text.resize(text.find_last_not_of('\0') + 1);
  }
  return text;
}

double Hdf5File::read_number(const std::string& object, const std::string& attribute) const {
  const Hdf5Handle a(
      H5Aopen_by_name(id_, object.c_str(), attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  double value = 0;
  if (!a.valid()) fail(object, "attribute \"" + attribute + "\" is missing");
  const Hdf5Handle space(H5Aget_space(a), H5Sclose);
  if (H5Sget_simple_extent_npoints(space) != 1 || H5Aread(a, H5T_NATIVE_DOUBLE, &value) < 0) {
    fail(object, "attribute \"" + attribute + "\" must be a number");
  }
  return value;
}

void Hdf5File::require_number(const std::string& dataset, Number number) const {
  shape(dataset);  // throws unless it is a dataset of numbers
  const Hdf5Handle set(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle type(H5Dget_type(set), H5Tclose);
  const auto [wanted, name] = storage_type(number);
  // Weights may be kept in half the bytes; HDF5 widens them as they are read.
  const bool half =
      number == Number::real32 && H5Tget_class(type) == H5T_FLOAT && H5Tget_size(type) == 2;
  if (!half && H5Tequal(type, wanted) <= 0) {
    fail(dataset, std::string("must be stored as ") + name);
  }
}

void Hdf5File::create_dataset(const std::string& dataset, const std::vector<std::uint64_t>& extent,
                              Number number) {
  const std::vector<hsize_t> dims(extent.begin(), extent.end());
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                         H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);  // equal content makes equal files
  H5Pset_layout(properties, H5D_CONTIGUOUS);
  H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER);
  const Hdf5Handle groups(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(groups, 1);
  const Hdf5Handle set(H5Dcreate2(id_, dataset.c_str(), storage_type(number).type, space, groups,
                                  properties, H5P_DEFAULT),
                       H5Dclose);
  if (!set.valid()) fail(dataset, "cannot be created; is the disk full?" + hdf5_message());
}

void Hdf5File::write_rows(const std::string& dataset, std::uint64_t first,
                          const RowMajorMatrix& rows) {
  const std::vector<std::uint64_t> extent = shape(dataset);
  std::vector<hsize_t> block(extent.begin(), extent.end());
  block[0] = static_cast<hsize_t>(rows.rows());
  const Hdf5Handle set(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  const Hdf5Handle memory(H5Screate_simple(static_cast<int>(block.size()), block.data(), nullptr),
                          H5Sclose);
  // Flushed here, because a failure to write on closing the dataset would go unseen.
  if (static_cast<std::uint64_t>(rows.cols()) != row_width(extent) ||
      !select_rows(space, first, block) ||
      H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, rows.data()) < 0 ||
      H5Dflush(set) < 0) {
    fail(dataset, not_written + hdf5_message());
  }
}

void Hdf5File::write_vector(const std::string& dataset, const Eigen::VectorXd& values) {
  create_dataset(dataset, {static_cast<std::uint64_t>(values.size())});
  write_rows(dataset, 0, values);
}

void Hdf5File::write_matrix(const std::string& dataset, const RowMajorMatrix& values) {
  create_dataset(dataset, {static_cast<std::uint64_t>(values.rows()),
                           static_cast<std::uint64_t>(values.cols())});
  write_rows(dataset, 0, values);
}

void Hdf5File::write_text(const std::string& object, const std::string& attribute,
                          const std::string& text) {
  const Hdf5Handle type(text_type(text), H5Tclose);
  const std::string padded = text.empty() ? std::string(1, '\0') : text;
  if (!write_attribute(id_, object, attribute, type, padded.data())) {
    fail(object, "attribute \"" + attribute + "\" " + not_written + hdf5_message());
  }
}

void Hdf5File::write_number(const std::string& object, const std::string& attribute, double value) {
  if (!write_attribute(id_, object, attribute, H5T_IEEE_F64LE, &value)) {
    fail(object, "attribute \"" + attribute + "\" " + not_written + hdf5_message());
  }
}

void Hdf5File::write_text_dataset(const std::string& dataset, const std::string& text) {
  const Hdf5Handle type(text_type(text), H5Tclose);
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  const Hdf5Handle set(
      H5Dcreate2(id_, dataset.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose);
  const std::string padded = text.empty() ? std::string(1, '\0') : text;
  if (!set.valid() || H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()) < 0 ||
      H5Dflush(set) < 0) {
    fail(dataset, not_written + hdf5_message());
  }
}

std::string Hdf5File::read_text_dataset(const std::string& dataset) const {
  const Hdf5Handle set(open_dataset(dataset), H5Dclose);
  const Hdf5Handle type(H5Dget_type(set), H5Tclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose);
  if (!type.valid() || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0 ||
      H5Sget_simple_extent_npoints(space) != 1) {
    fail(dataset, "must be one string of fixed length");
  }
  std::string text(H5Tget_size(type), '\0');
  if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) {
    fail(dataset, damaged + hdf5_message());
  }
  text.resize(text.find_last_not_of('\0') + 1);
  return text;
}

void Hdf5File::write_checksum() {
  if (has_attribute("/", "checksum")) H5Adelete(id_, "checksum");
  std::string checksum;
  try {
    checksum = checksum_of_contents(id_);
  } catch (const std::runtime_error& error) {
    fail("/", std::string("no checksum can be made: ") + error.what() + "; write it again");
  }
  write_text("/", "checksum", checksum);
}

std::string Hdf5File::why_changed() const {
  if (!has_attribute("/", "checksum")) return "it has no checksum";
  try {
    const bool same = read_text("/", "checksum") == checksum_of_contents(id_);
    return same ? "" : "it has been changed since it was written";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

void Hdf5File::flush() {
  if (H5Fflush(id_, H5F_SCOPE_GLOBAL) < 0) fail("/", not_written + hdf5_message());
}

void Hdf5File::close() {
  // The library crashes if a file is closed twice, even after a failure.
  if (H5Fclose(std::exchange(id_, -1)) < 0) fail("/", not_written + hdf5_message());
}

}  // namespace ertbench
