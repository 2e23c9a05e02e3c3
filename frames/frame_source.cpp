#include "frames/frame_source.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view hdf5_signature = "\x89HDF\r\n\x1a\n";

std::string first_bytes(const fs::path& file, std::size_t count) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": cannot be opened; check the name and its rights");
  std::string bytes(count, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

/// The library looks for its signature at 0, 512, 1024, ...: MATLAB puts 512 bytes before it.
bool is_hdf5(const std::string& begin) {
  for (std::size_t at = 0; at + hdf5_signature.size() <= begin.size(); at = at ? 2 * at : 512) {
    if (begin.compare(at, hdf5_signature.size(), hdf5_signature) == 0) return true;
  }
  return false;
}

bool is_named(const fs::path& file, std::string_view ending) {
  std::string found = file.extension().string();
  std::transform(found.begin(), found.end(), found.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return found == ending;
}

}  // namespace

RowMajorMatrix FrameSource::table(const std::string& name) const {
  throw InputError(files().front().string() + ": has no dataset " + name +
                   ", as it is no HDF5 file; give a file of the order");
}

std::unique_ptr<FrameSource> open_frames(const fs::path& input, const FrameFileOptions& options) {
  std::error_code error;
  if (!fs::exists(input, error)) {
    throw InputError(input.string() + ": does not exist; check the name");
  }
  if (fs::is_directory(input, error)) return open_eit_frames(input, options);
  require_regular_file(input);
  const std::string begin = first_bytes(input, 4096);
  if (begin.find("Draeger EIT-Software") != std::string::npos) {
    throw InputError(input.string() +
                     ": is a recording of a Draeger device, whose layout is not public; export it "
                     "as text in the device's program, or read it with EIDORS (eidors_readdata) "
                     "and save the frames as [N, 208] for --channels rotating");
  }
  if (begin.starts_with("MATLAB 5.0")) return open_matlab_frames(input, options);
  if (is_hdf5(begin)) return open_hdf5_frames(input, options, begin.starts_with("MATLAB 7.3"));
  if (is_named(input, ".mat")) return open_matlab_frames(input, options);
  for (const char* ending : {".h5", ".hdf5", ".hdf"}) {
    // The library says what is wrong with it.
    if (is_named(input, ending)) return open_hdf5_frames(input, options, false);
  }
  if (is_named(input, ".get")) return open_get_frames(input, options);
  if (is_named(input, ".eit")) return open_eit_frames(input, options);
  if (is_unified(begin)) return open_unified_frames(input, options);
  return open_csv_frames(input, options);
}

bool is_hdf5_file(const fs::path& file) { return is_hdf5(first_bytes(file, 4096)); }

void require_same_missing(const RowMajorMatrix& rows, std::uint64_t first,
                          const RowMajorMatrix& begin, const std::string& place) {
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    for (Eigen::Index c = 0; c < rows.cols(); ++c) {
      const bool is_number = std::isfinite(rows(r, c));
      const bool is_missing = std::isnan(begin(0, c));
      if (is_missing ? std::isnan(rows(r, c)) : is_number) continue;
      throw InputError(
          place + ": row " + std::to_string(first + static_cast<std::uint64_t>(r)) + ", column " +
          std::to_string(c) + ", counted from 0: " +
          (is_number ? "is a number, which the first frame has not there" : "is not finite") +
          "; leave such frames out");
    }
  }
}

std::string checksum_of(const std::vector<fs::path>& files) {
  Checksum checksum;
  std::string block(std::size_t{1} << 20U, '\0');
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file.string() + ": cannot be opened; check the name and its rights");
    while (in.read(block.data(), static_cast<std::streamsize>(block.size())), in.gcount() > 0) {
      checksum.add(std::string_view(block).substr(0, static_cast<std::size_t>(in.gcount())));
    }
  }
  return checksum.text();
}

std::string text_of_file(const fs::path& file) {
  require_regular_file(file);
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error || size > most_text_bytes) {
    throw InputError(file.string() + ": has more than " + std::to_string(most_text_bytes >> 20U) +
                     " MB of text; keep frames as HDF5, which is read piece by piece");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": cannot be opened; check the name and its rights");
  std::string text(static_cast<std::size_t>(size), '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

}  // namespace ertbench
