#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// Owner of one open HDF5 file. Every error becomes an InputError that names the file and the
/// object. Safe for files from elsewhere, but for defects of the library: links to other files,
/// values stored in other files, filters from plugins, and datasets that declare more values than
/// are stored are refused. Not thread-safe; a process may use one file at a time.
class Hdf5File {
 public:
  static Hdf5File open(const std::filesystem::path& file);           ///< for reading
  static Hdf5File open_writable(const std::filesystem::path& file);  ///< an existing file
  static Hdf5File create(const std::filesystem::path& file);         ///< replaces an existing file
  /// Whether a file can be opened and has the object.
  static bool holds(const std::filesystem::path& file, const std::string& object);

  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  ~Hdf5File();

  bool has(const std::string& object) const;
  bool has_attribute(const std::string& object, const std::string& name) const;
  /// Names in a group, in alphabetical order; empty without such a group. Throws if one of them is
  /// a link to elsewhere.
  std::vector<std::string> names(const std::string& group) const;

  /// Dimensions of a dataset of numbers. Throws if it is absent or of another type.
  std::vector<std::uint64_t> shape(const std::string& dataset) const;
  /// Throws unless the dataset has `expected` dimensions, 0 standing for any extent >= 1.
  std::vector<std::uint64_t> require_shape(const std::string& dataset,
                                           const std::vector<std::uint64_t>& expected) const;
  /// Rows [first, first + count) of a dataset, its other dimensions flattened. Refuses values that
  /// are not finite unless `allow_nan`.
  RowMajorMatrix read_rows(const std::string& dataset, std::uint64_t first, std::uint64_t count,
                           bool allow_nan = false) const;
  /// A whole one-dimensional dataset.
  Eigen::VectorXd read_vector(const std::string& dataset) const;
  std::string read_text(const std::string& object, const std::string& attribute) const;
  double read_number(const std::string& object, const std::string& attribute) const;

  enum class Number { real64, uint8, real32, int64 };
  /// Throws unless the dataset is stored as numbers of this type; real32 may be real16 there.
  void require_number(const std::string& dataset, Number number) const;

  /// Creates a dataset and reserves its storage at once, so that a file cut short later is still
  /// readable. Creates missing groups of its name ("/group/dataset").
  void create_dataset(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                      Number number = Number::real64);
  void write_rows(const std::string& dataset, std::uint64_t first, const RowMajorMatrix& rows);
  void write_vector(const std::string& dataset, const Eigen::VectorXd& values);  ///< creates it
  void write_matrix(const std::string& dataset, const RowMajorMatrix& values);   ///< creates it
  void write_text(const std::string& object, const std::string& attribute, const std::string& text);
  void write_number(const std::string& object, const std::string& attribute, double value);
  /// A text of any length as a dataset of its own; attributes end at 64 kB.
  void write_text_dataset(const std::string& dataset, const std::string& text);
  std::string read_text_dataset(const std::string& dataset) const;

  /// Stores a checksum of the file's contents in the root's attribute "checksum".
  void write_checksum();
  /// Why the contents differ from those of write_checksum ("it has no checksum", "it has been
  /// changed since it was written"); empty if they are the same. Reads the whole file.
  std::string why_changed() const;
  /// Hands all that was written to the operating system.
  void flush();
  /// Closes the file. Writers call this last: it throws if the operating system does not take the
  /// data, which the destructor cannot report.
  void close();

  const std::filesystem::path& path() const { return path_; }

 private:
  Hdf5File(std::filesystem::path file, std::int64_t id) : path_(std::move(file)), id_(id) {}
  [[noreturn]] void fail(const std::string& object, const std::string& message) const;
  /// The library's identifier of a dataset whose values can be read; the caller closes it.
  std::int64_t open_dataset(const std::string& dataset) const;

  std::filesystem::path path_;
  std::int64_t id_ = -1;
};

}  // namespace ertbench
