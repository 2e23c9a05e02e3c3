#include "frames/frame_source.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <utility>

#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/text.h"

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
  if (begin.starts_with("MATLAB 5.0")) {
    throw InputError(input.string() +
                     ": is a MATLAB file of version 7 or earlier, which is no HDF5; save it with "
                     "save('-v7.3', ...), in Octave with save('-hdf5', ...)");
  }
  if (is_hdf5(begin)) return open_hdf5_frames(input, options, begin.starts_with("MATLAB 7.3"));
  for (const char* ending : {".h5", ".hdf5", ".hdf", ".mat"}) {
    // The library says what is wrong with it.
    if (is_named(input, ending)) return open_hdf5_frames(input, options, false);
  }
  if (is_named(input, ".eit")) return open_eit_frames(input, options);
  return open_csv_frames(input, options);
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

namespace {

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

/// The fields of a line, separated by semicolons, commas or tabs if there are any, else by blanks.
std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  const char* separator = "";
  for (const char* candidate : {";", ",", "\t"}) {
    if (*separator == '\0' && line.find(candidate) != std::string_view::npos) separator = candidate;
  }
  const char* const ends = *separator != '\0' ? separator : " ";
  while (true) {
    const std::size_t end = line.find_first_of(ends);
    const std::string_view field = trimmed(line.substr(0, end));
    if (*separator != '\0' || !field.empty()) fields.push_back(field);
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  // Some programs end every number with a separator.
  if (fields.size() > 1 && fields.back().empty()) fields.pop_back();
  return fields;
}

/// True if the whole text is a number, possibly quoted or with a leading "+".
bool is_number(std::string_view text, double& value) {
  if (text.size() > 1 && text.front() == '"' && text.back() == '"') {
    text = text.substr(1, text.size() - 2);
  }
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

class CsvFrames final : public FrameSource {
 public:
  CsvFrames(fs::path input, const FrameFileOptions& options) : path_(std::move(input)) {
    if (!options.dataset.empty()) {
      throw InputError(path_.string() +
                       ": is read as text, which has no datasets; leave --dataset out");
    }
    rows_ = numbers_of_text(text_of_file(path_), path_.string());
    if (options.transposed.value_or(false)) rows_.transposeInPlace();
  }

  std::string format() const override { return "CSV"; }
  std::uint64_t frames() const override { return static_cast<std::uint64_t>(rows_.rows()); }
  Eigen::Index columns() const override { return rows_.cols(); }
  RowMajorMatrix read(std::uint64_t first, std::uint64_t count) const override {
    return rows_.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
  }
  std::vector<fs::path> files() const override { return {path_}; }

 private:
  fs::path path_;
  RowMajorMatrix rows_;
};

}  // namespace

bool is_title_line(std::string_view line) {
  constexpr std::size_t least_counted = 8;  // shorter lines may be rows of an order of channels
  const std::vector<std::string_view> fields = fields_of(line);
  std::size_t numbers = 0;
  bool counts = fields.size() >= least_counted;
  for (std::size_t c = 0; c < fields.size(); ++c) {
    double value = 0;
    const bool number = is_number(fields[c], value);
    numbers += number;
    counts = counts && number && value == static_cast<double>(c);
  }
  return numbers == 0 || counts;
}

RowMajorMatrix numbers_of_text(std::string_view text, const std::string& source) {
  std::vector<double> values;
  std::size_t columns = 0;
  std::size_t number = 0;
  std::size_t rows = 0;
  bool first = true;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    if (line.empty() || line.front() == '#') continue;
    if (std::exchange(first, false) && is_title_line(line)) continue;
    const std::vector<std::string_view> fields = fields_of(line);
    const auto place = [&](std::size_t column) {
      return source + ": line " + std::to_string(number) + ", column " +
             std::to_string(column + 1) + ": ";
    };
    for (std::size_t c = 0; c < fields.size(); ++c) {
      double value = 0;
      if (!is_number(fields[c], value)) {
        throw InputError(place(c) + "must be a number, is \"" + printable(fields[c], 40) + "\"");
      }
      if (!std::isfinite(value)) {
        throw InputError(place(c) + "is not finite; leave such frames out");
      }
      values.push_back(value);
    }
    if (columns == 0) columns = fields.size();
    if (fields.size() != columns) {
      throw InputError(source + ": line " + std::to_string(number) + ": has " +
                       std::to_string(fields.size()) + " numbers, the lines before have " +
                       std::to_string(columns) + "; one frame stands in one line");
    }
    ++rows;
  }
  if (rows == 0) {
    throw InputError(source + ": holds no numbers; one frame stands in one line");
  }
  return Eigen::Map<const RowMajorMatrix>(values.data(), static_cast<Eigen::Index>(rows),
                                          static_cast<Eigen::Index>(columns));
}

std::unique_ptr<FrameSource> open_csv_frames(const fs::path& input,
                                             const FrameFileOptions& options) {
  return std::make_unique<CsvFrames>(input, options);
}

}  // namespace ertbench
