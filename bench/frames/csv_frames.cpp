#include "bench/frames/csv_frames.h"

#include <charconv>
#include <cmath>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

/// The fields of a line: between commas, semicolons or tabs where there are any, else between
/// blanks.
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
  // Programs that end each number with a separator mean no more numbers.
  if (fields.size() > 1 && fields.back().empty()) fields.pop_back();
  return fields;
}

/// Whether the whole of a text is a number; a leading "+" is one's own business.
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
    if (options.transposed) rows_.transposeInPlace();
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
    const std::vector<std::string_view> fields = fields_of(line);
    const auto place = [&](std::size_t column) {
      return source + ": line " + std::to_string(number) + ", column " +
             std::to_string(column + 1) + ": ";
    };
    const std::size_t before = values.size();
    for (std::size_t c = 0; c < fields.size(); ++c) {
      double value = 0;
      if (is_number(fields[c], value)) {
        if (!std::isfinite(value)) {
          throw InputError(place(c) + "is not finite; leave such frames out");
        }
        values.push_back(value);
        continue;
      }
      values.resize(before);
      if (first) break;  // titles
      throw InputError(place(c) + "must be a number, is \"" + printable(fields[c], 40) + "\"");
    }
    const bool titles = first && values.size() == before;
    first = false;
    if (titles) continue;
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
