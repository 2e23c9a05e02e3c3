#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>

namespace ertbench {

/// Closes an HDF5 identifier.
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

/// Keeps the HDF5 library from following links to other files and from loading filters as plugins,
/// for this whole process. Called before anything else of the library.
void forbid_foreign_hdf5();

/// Why the values of an opened dataset are not read: they are in other files, or fewer than the
/// dataset declares, so that reading would make up for what nobody stored; empty where they are.
/// `dataset`: the library's identifier.
std::string why_not_read(std::int64_t dataset);

/// A checksum of all that an open HDF5 file holds: names, types, shapes and values of its datasets
/// in all groups, and the root's attributes, but the attribute "checksum". How the values lie in
/// the file is no part of it. Throws std::runtime_error where the library cannot read something.
/// `file`: the library's identifier.
std::string checksum_of_contents(std::int64_t file);

}  // namespace ertbench
