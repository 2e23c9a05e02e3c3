#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// A thin owner of one open HDF5 file. Every error becomes an InputError that names the file and
/// the object. Files of hostile origin are no danger beyond what a defect of the library may do:
/// links to other files, values kept in other files, filters from plugins and datasets that declare
/// more than is stored are refused. Not thread-safe: one thread a file, and one file at a time for
/// each process.
class Hdf5File {
 public:
  static Hdf5File open(const std::filesystem::path& file);  ///< to read
  static Hdf5File open_writable(
      const std::filesystem::path& file);                     ///< existing, to read and write
  static Hdf5File create(const std::filesystem::path& file);  ///< replaces what is there

  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  ~Hdf5File();

  bool has(const std::string& object) const;
  bool has_attribute(const std::string& object, const std::string& name) const;
  /// What a group holds, in alphabetical order; nothing where there is no such group. Throws where
  /// one of it is a link to elsewhere.
  std::vector<std::string> names(const std::string& group) const;

  /// Dimensions of a dataset of real numbers. Throws where it is absent or of another type.
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
  /// Throws unless the dataset is stored as numbers of this type.
  void require_number(const std::string& dataset, Number number) const;

  /// A dataset whose storage is reserved at once, so that a file cut short later is still readable.
  /// Groups on the way to it ("/group/dataset") are made where they are missing.
  void create_dataset(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                      Number number = Number::real64);
  void write_rows(const std::string& dataset, std::uint64_t first, const RowMajorMatrix& rows);
  void write_vector(const std::string& dataset, const Eigen::VectorXd& values);  ///< creates it
  void write_matrix(const std::string& dataset, const RowMajorMatrix& values);   ///< creates it
  void write_text(const std::string& object, const std::string& attribute, const std::string& text);
  void write_number(const std::string& object, const std::string& attribute, double value);
  /// A text as a dataset of its own, of any length: attributes end at 64 kB.
  void write_text_dataset(const std::string& dataset, const std::string& text);
  std::string read_text_dataset(const std::string& dataset) const;

  /// Puts a checksum of all that the file holds into the root's attribute "checksum".
  void write_checksum();
  /// Why the file is not what write_checksum saw: "it has no checksum", "it has been changed since
  /// it was written"; empty where it is. Reads all of it.
  std::string why_changed() const;
  /// Hands everything to the operating system.
  void flush();
  /// Ends the use of the file. Throws where what was written cannot be handed to the operating
  /// system, which the destructor keeps to itself: whoever writes a file calls this last.
  void close();

  const std::filesystem::path& path() const { return path_; }

 private:
  Hdf5File(std::filesystem::path file, std::int64_t id) : path_(std::move(file)), id_(id) {}
  [[noreturn]] void fail(const std::string& object, const std::string& message) const;

  std::filesystem::path path_;
  std::int64_t id_ = -1;
};

}  // namespace ertbench
