// The numbers of the frame check in the file of a fitted solver.

#include <array>
#include <atomic>
#include <fstream>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "solvers/check/checked_solver.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr const char* container_attribute = "contains_solver_file";
constexpr int container_version = 1;
constexpr const char* contents = "/solver_file";
constexpr const char* check = "/frame_check";
/// Bytes copied at a time; as the doubles of Hdf5File they take eight times as much memory.
constexpr std::uint64_t chunk = 1 << 20;

bool is_hdf5(const fs::path& file) {
  constexpr std::array<char, 8> signature = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  std::array<char, 8> start{};
  std::ifstream in(file, std::ios::binary);
  if (!in && fs::exists(file)) {
    throw InputError(file.string() + ": cannot be read; check its permissions");
  }
  return in.read(start.data(), start.size()) && start == signature;
}

void pack(const fs::path& from, Hdf5File& container) {
  std::ifstream in(from, std::ios::binary);
  const std::uint64_t size = fs::file_size(from);
  container.create_dataset(contents, {size}, Hdf5File::Number::uint8);
  std::string bytes;
  for (std::uint64_t first = 0; first < size; first += chunk) {
    bytes.resize(std::min(chunk, size - first));
    if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
      throw InputError(from.string() + ": cannot be read");
    }
    RowMajorMatrix numbers(static_cast<Eigen::Index>(bytes.size()), 1);
    std::transform(bytes.begin(), bytes.end(), numbers.data(),
                   [](char byte) { return static_cast<unsigned char>(byte); });
    container.write_rows(contents, first, numbers);
  }
}

void unpack(const Hdf5File& container, const fs::path& to) {
  const std::uint64_t size = container.shape(contents).front();
  std::ofstream out(to, std::ios::binary);
  std::string bytes;
  for (std::uint64_t first = 0; first < size; first += chunk) {
    const RowMajorMatrix numbers =
        container.read_rows(contents, first, std::min(chunk, size - first));
    bytes.resize(static_cast<std::size_t>(numbers.size()));
    std::transform(numbers.data(), numbers.data() + numbers.size(), bytes.begin(),
                   [](double byte) { return static_cast<char>(static_cast<unsigned char>(byte)); });
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  if (!out.flush()) throw InputError(to.string() + ": cannot be written; is the disk full?");
}

/// Wraps the file that the solver saved, if any, in an HDF5 file of the same name.
Hdf5File make_container(const fs::path& file) {
  fs::path aside = file;
  aside += ".contents";
  const bool saved = fs::exists(file);
  if (saved) fs::rename(file, aside);
  try {
    Hdf5File container = Hdf5File::create(file);
    container.write_number("/", container_attribute, container_version);
    // Storage of a dataset without elements cannot be reserved.
    if (saved && fs::file_size(aside) > 0) pack(aside, container);
    fs::remove(aside);
    return container;
  } catch (...) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    throw;
  }
}

/// Folder for the contents of one container. Several threads may load at the same time.
std::string folder_name() {
  static std::atomic<int> count = 0;
  return "solver_file_" + std::to_string(count++);
}

}  // namespace

void add_frame_check(const fs::path& file, const SolverOwner& owner,
                     const Eigen::VectorXd& numbers) {
  const bool has_place = is_hdf5(file) && !Hdf5File::open(file).has(check);
  Hdf5File out = has_place ? Hdf5File::open_writable(file) : make_container(file);
  if (!out.has_attribute("/", "solver")) write_owner(out, owner.type, owner.sensor);
  out.write_vector(check, numbers);
  out.write_checksum();
  out.close();
}

CheckedFile::CheckedFile(const fs::path& file, const SolverOwner& owner) : of_solver_(file) {
  if (!fs::exists(file)) throw InputError(file.string() + ": there is no such file");
  if (!is_hdf5(file)) return;
  const Hdf5File in = Hdf5File::open(file);
  if (!in.has_attribute("/", "solver")) return;
  require_owner(in, owner.type, owner.sensor);
  // Files of versions up to 0.2 have no frame check.
  if (in.has_attribute("/", "checksum")) {
    if (const std::string why = in.why_changed(); !why.empty()) {
      throw InputError(file.string() + ": " + why + "; fit the solver anew");
    }
  }
  if (in.has(check)) frame_check_ = in.read_vector(check);
  if (!in.has_attribute("/", container_attribute)) return;
  unpacked_.emplace(folder_name());
  of_solver_ = *unpacked_ / file.filename();
  if (in.has(contents)) unpack(in, of_solver_);
}

}  // namespace ertbench
