#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/errors.h"
#include "frames/frame_source.h"
#include "frames/text_lines.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr int most_electrodes = 256;
constexpr int most_frequencies = 1024;
constexpr int most_header_lines = 1000;
constexpr std::string_view used_list = "MeasurementChannels:";
constexpr std::string_view column_list = "MeasurementChannelsIndependentFromInjectionPattern:";

class EitLines : public NumberedLines {
 public:
  using NumberedLines::NumberedLines;

  std::string_view header(const char* what) {
    const auto line = next();
    if (!line) fail(std::string("the header ends before ") + what);
    return *line;
  }
  double number_of(std::string_view line, const char* what) const {
    const std::vector<double> values = numbers(line);
    if (values.size() != 1) fail(std::string("must be ") + what);
    return values.front();
  }
  int integer_of(std::string_view line, const char* what, int low, int high) const {
    const double value = number_of(line, what);
    if (!(value >= low && value <= high) || value != std::floor(value)) {
      fail(std::string("must be ") + what + ", a whole number from " + std::to_string(low) +
           " to " + std::to_string(high));
    }
    return static_cast<int>(value);
  }

  /// Electrodes counted from 0; the file counts from 1.
  std::vector<int> electrodes(std::string_view line) const {
    std::vector<int> out;
    for (const double value : numbers(line)) {
      if (!(value >= 1 && value <= most_electrodes) || value != std::floor(value)) {
        fail("electrodes are whole numbers from 1 to " + std::to_string(most_electrodes));
      }
      out.push_back(static_cast<int>(value) - 1);
    }
    return out;
  }
};

struct EitHeader {
  std::vector<int> used;
  std::vector<int> columns;
};

EitHeader read_header(EitLines& lines, EitFile& file) {
  EitHeader header;
  const int count = lines.integer_of(lines.header("the number of its lines"),
                                     "the number of lines of the header", 9, most_header_lines);
  if (count == 10) lines.fail("a header has 9 lines, or 11 and more");
  if (count >= 11) lines.header("the version");
  lines.header("the name");
  lines.header("the date");
  lines.number_of(lines.header("the least frequency"), "the least frequency, Hz");
  lines.number_of(lines.header("the largest frequency"), "the largest frequency, Hz");
  lines.header("the scale");
  file.frequencies = lines.integer_of(lines.header("the number of frequencies"),
                                      "the number of frequencies", 1, most_frequencies);
  file.current = lines.number_of(lines.header("the amplitude"), "the amplitude of the current, A");
  if (lines.number() < count) {
    lines.number_of(lines.header("the frame rate"), "the frames a second");
  }
  while (lines.number() < count) {
    const std::string_view line = lines.header("its last line");
    if (line.starts_with(column_list)) {
      header.columns = lines.electrodes(line.substr(column_list.size()));
    } else if (line.starts_with(used_list)) {
      header.used = lines.electrodes(line.substr(used_list.size()));
    }
  }
  return header;
}

/// The number in a name: "setup_00012.eit" -> 12.
std::uint64_t number_in(const fs::path& file) {
  const std::string name = file.stem().string();
  const std::size_t last = name.find_last_of("0123456789");
  if (last == std::string::npos) return 0;
  const std::size_t before = name.find_last_not_of("0123456789", last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  std::uint64_t value = 0;
  std::from_chars(name.data() + first, name.data() + last + 1, value);
  return value;
}

std::vector<fs::path> eit_files(const fs::path& input) {
  if (!fs::is_directory(input)) return {input};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(input)) {
    if (entry.path().extension() == ".eit") files.push_back(entry.path());
  }
  if (files.empty()) {
    throw InputError(input.string() + ": is a folder without .eit files; name the one with them");
  }
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    const std::uint64_t left = number_in(a);
    const std::uint64_t right = number_in(b);
    return left != right ? left < right : a < b;
  });
  return files;
}

class EitFrames final : public FrameSource {
 public:
  EitFrames(const fs::path& input, const FrameFileOptions& options) : files_(eit_files(input)) {
    if (options.transposed.value_or(false)) {
      throw InputError(input.string() + ": is an .eit recording; leave --transposed out");
    }
    for (const fs::path& path : files_) add(path, options.dataset);
  }

  std::string format() const override { return "eit"; }
  std::uint64_t frames() const override { return files_.size(); }
  Eigen::Index columns() const override {
    return static_cast<Eigen::Index>(first_.injections.size() * first_.electrodes.size());
  }
  RowMajorMatrix read(std::uint64_t first, std::uint64_t count) const override {
    return Eigen::Map<const RowMajorMatrix>(values_.data(),
                                            static_cast<Eigen::Index>(files_.size()), columns())
        .middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
  }
  std::vector<Injection> injections() const override { return first_.injections; }
  std::vector<int> electrodes() const override { return first_.electrodes; }
  std::optional<double> current() const override { return first_.current; }
  std::vector<fs::path> files() const override { return files_; }

 private:
  void add(const fs::path& path, const std::string& frequency) {
    EitFile file = parse_eit(text_of_file(path), path.string());
    const Eigen::Index chosen = frequency_of(file, frequency, path);
    const auto electrodes = static_cast<Eigen::Index>(file.electrodes.size());
    for (Eigen::Index i = 0; i < file.in_phase.rows(); ++i) {
      for (Eigen::Index e = 0; e < electrodes; ++e) {
        values_.push_back(file.in_phase(i, chosen * electrodes + e));
      }
    }
    if (path == files_.front()) {
      first_ = std::move(file);
    } else if (file.injections != first_.injections || file.electrodes != first_.electrodes ||
               file.current != first_.current) {
      throw InputError(path.string() + ": is of another setup than " + files_.front().string() +
                       "; keep recordings in folders of their own");
    }
  }

  static Eigen::Index frequency_of(const EitFile& file, const std::string& wanted,
                                   const fs::path& path) {
    if (wanted.empty() && file.frequencies == 1) return 0;
    int number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error != std::errc() || end != wanted.data() + wanted.size() || number < 1 ||
        number > file.frequencies) {
      throw InputError(path.string() + ": holds " + std::to_string(file.frequencies) +
                       " frequencies; choose one by --dataset, from 1");
    }
    return number - 1;
  }

  std::vector<fs::path> files_;
  EitFile first_;
  std::vector<double> values_;
};

}  // namespace

EitFile parse_eit(std::string_view text, const std::string& source) {
  EitLines lines(text, source);
  EitFile file;
  const EitHeader header = read_header(lines, file);
  std::vector<double> in_phase;
  std::size_t columns = 0;
  while (auto line = lines.next()) {
    if (line->empty()) continue;
    const std::vector<int> pair = lines.electrodes(*line);
    if (pair.size() != 2) lines.fail("must name the two electrodes of an injection");
    file.injections.push_back({pair[0], pair[1]});
    for (int f = 0; f < file.frequencies; ++f) {
      line = lines.next();
      if (!line) lines.fail("the file ends within an injection; it is cut short");
      const std::vector<double> values = lines.numbers(*line);
      if (columns == 0) columns = values.size() / 2;
      if (values.empty() || values.size() % 2 != 0 || values.size() != 2 * columns ||
          columns > static_cast<std::size_t>(most_electrodes)) {
        lines.fail("must hold real and imaginary part of each electrode, " +
                   std::to_string(2 * columns) + " numbers; has " + std::to_string(values.size()));
      }
      for (std::size_t i = 0; i < values.size(); i += 2) in_phase.push_back(values[i]);
    }
  }
  if (file.injections.empty()) lines.fail("the file ends behind the header; it is cut short");

  // Electrodes of the columns: by the list of columns, else by that of electrodes in use, whichever
  // has the right length; else in order.
  std::vector<int> labels;
  for (const std::vector<int>* list : {&header.columns, &header.used}) {
    if (labels.empty() && list->size() == columns) labels = *list;
  }
  for (std::size_t c = labels.size(); c < columns; ++c) labels.push_back(static_cast<int>(c));
  std::vector<std::size_t> kept;
  for (std::size_t c = 0; c < columns; ++c) {
    const bool used =
        header.used.empty() || std::ranges::find(header.used, labels[c]) != header.used.end();
    if (used) {
      kept.push_back(c);
      file.electrodes.push_back(labels[c]);
    }
  }
  const auto rows = static_cast<Eigen::Index>(file.injections.size());
  const auto frequencies = static_cast<std::size_t>(file.frequencies);
  file.in_phase.resize(rows, static_cast<Eigen::Index>(frequencies * kept.size()));
  for (std::size_t block = 0; block < static_cast<std::size_t>(rows) * frequencies; ++block) {
    for (std::size_t k = 0; k < kept.size(); ++k) {
      file.in_phase.data()[block * kept.size() + k] = in_phase[block * columns + kept[k]];
    }
  }
  return file;
}

std::unique_ptr<FrameSource> open_eit_frames(const fs::path& input,
                                             const FrameFileOptions& options) {
  return std::make_unique<EitFrames>(input, options);
}

}  // namespace ertbench
