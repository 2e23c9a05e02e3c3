#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>

namespace ertbench {

/// Owner of an HDF5 identifier.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT: meant to stand in for the identifier
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// " (HDF5: …)" with the innermost message of the library's error stack; empty without one.
std::string hdf5_message();

/// Keeps the HDF5 library from following links to other files and from loading filters as plugins
/// in this process. Call it before any other function of the library.
void forbid_foreign_hdf5();

/// Why the values of an opened dataset cannot be read: they are in other files, or fewer than the
/// dataset declares, so that the library would invent the rest. Empty if they can be read.
/// `dataset`: the library's identifier.
std::string why_not_read(std::int64_t dataset);

/// Checksum of the contents of an open HDF5 file: names, types, shapes and values of the datasets
/// in all groups, and the root's attributes except "checksum". It does not depend on the file's
/// layout. Throws std::runtime_error if the library cannot read something. `file`: the library's
/// identifier.
std::string checksum_of_contents(std::int64_t file);

}  // namespace ertbench
