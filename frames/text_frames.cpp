// Tables of numbers as text: one frame a line.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ranges>
#include <span>

#include "core/errors.h"
#include "core/lists.h"
#include "core/text.h"
#include "frames/frame_source.h"
#include "frames/text_lines.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// The cells of one column that are no numbers.
struct OddCells {
  std::size_t words = 0;
  std::size_t marks = 0;
  std::size_t first_line = 0;  ///< of a word or a mark
  std::string first;
};

/// A text as numbers, with NaN where a cell is none.
struct Cells {
  std::vector<double> values;  ///< [rows, columns]
  std::size_t rows = 0;
  std::vector<OddCells> columns;
  std::vector<std::string_view> titles;  ///< those of the last line before the numbers
  std::size_t passed_lines = 0;          ///< lines without numbers before the frames
  std::string prefix;
  bool is_complex = false;
  NumberFormat format;
};

/// "magnitudes" of "magnitudes 3 :".
std::string letters_of(const std::string& prefix) {
  std::string out;
  for (const char c : prefix) {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) out += c;
  }
  return out;
}

class TextReader {
 public:
  explicit TextReader(const std::string& source) : source_(source) {}

  Cells read(std::string_view text) {
    while (!text.empty()) {
      const std::size_t end = text.find_first_of("\r\n");
      const std::string_view line = trimmed(text.substr(0, end));
      const bool is_pair = end != std::string_view::npos && text.substr(end, 2) == "\r\n";
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + (is_pair ? 2 : 1));
      ++line_;
      if (line.empty() || line.front() == '#' || line.front() == '%') continue;
      take(line);
    }
    if (cells_.rows == 0) {
      throw InputError(source_ + ": holds no numbers; one frame stands in one line");
    }
    if (!refusal_.empty() && cells_.columns.size() <= most_in_head) throw InputError(refusal_);
    return std::move(cells_);
  }

 private:
  static constexpr std::size_t most_in_head = 3;  ///< numbers in a line before the frames

  void take(std::string_view line) {
    const std::string_view whole = line;
    std::string prefix;
    if (cells_.rows == 0 && is_title_line(without_prefix(line, prefix))) {
      title_line_ = line;
      ++cells_.passed_lines;
      return;
    }
    line = without_prefix(line, prefix);
    if (cells_.rows > 0 && letters_of(prefix) != letters_of(cells_.prefix)) {
      const std::string refusal = place() + "begins with \"" + printable(prefix, 40) +
                                  "\", the lines before with \"" + printable(cells_.prefix, 40) +
                                  "\"; keep lines of one kind, one frame in each";
      if (cells_.columns.size() > most_in_head) throw InputError(refusal);
      // "Samples: 20" of an instrument's head, if frames follow.
      if (refusal_.empty()) refusal_ = refusal;
      cells_.passed_lines += cells_.rows;
      cells_.rows = 0;
      cells_.values.clear();
      return take(whole);
    }
    if (cells_.rows == 0) begin(line, prefix);
    const std::vector<std::string_view> fields = fields_of(line, cells_.format);
    if (cells_.rows == 0) {
      cells_.columns.assign(fields.size(), {});
    } else if (fields.size() != cells_.columns.size()) {
      fail("has " + std::to_string(fields.size()) + " numbers, the lines before have " +
           std::to_string(cells_.columns.size()) + "; one frame stands in one line");
    }
    for (std::size_t c = 0; c < fields.size(); ++c) add(fields[c], cells_.columns[c]);
    ++cells_.rows;
  }

  void begin(std::string_view line, const std::string& prefix) {
    cells_.prefix = prefix;
    cells_.format = number_format_of(line);
    if (!title_line_.empty()) cells_.titles = fields_of(title_line_, cells_.format);
    // Decimal commas between commas: "0,0399,0,0175".
    const std::vector<std::string_view> fields = fields_of(line, cells_.format);
    const auto is_whole = [](std::string_view field) {
      return field.find_first_not_of("+-0123456789") == std::string_view::npos;
    };
    const auto has_zeros = [](std::string_view field) {
      return field.size() > 1 && field.front() == '0';
    };
    if (cells_.format.separator == ',' && std::ranges::all_of(fields, is_whole) &&
        std::ranges::any_of(fields, has_zeros)) {
      fail(
          "has commas in its numbers and between them, which cannot be told apart; save the table "
          "with semicolons or tabs between the numbers, or with decimal points");
    }
  }

  void add(std::string_view field, OddCells& column) {
    const auto value = number_of(field, cells_.format, cells_.is_complex);
    const bool is_finite = value && std::isfinite(*value);
    cells_.values.push_back(is_finite ? *value : std::nan(""));
    if (is_finite) return;
    if (column.words + column.marks == 0) {
      column.first_line = line_;
      column.first = printable(field, 40);
    }
    (value || is_missing_mark(field) ? column.marks : column.words) += 1;
  }

  std::string place() const { return source_ + ": line " + std::to_string(line_) + ": "; }
  [[noreturn]] void fail(const std::string& what) const { throw InputError(place() + what); }

  const std::string& source_;
  Cells cells_;
  std::string_view title_line_;
  std::string refusal_;  ///< if what was taken for a head is none
  std::size_t line_ = 0;
};

Eigen::Map<const RowMajorMatrix> matrix_of(const Cells& cells) {
  return {cells.values.data(), static_cast<Eigen::Index>(cells.rows),
          static_cast<Eigen::Index>(cells.columns.size())};
}

/// Refuses cells of the columns that are no numbers.
void require_numbers(const Cells& cells, const std::vector<TitledColumns::Column>& columns,
                     const std::string& source) {
  std::optional<std::size_t> worst;
  for (const TitledColumns::Column& column : columns) {
    for (const std::size_t c : {column.value, column.phase.value_or(column.value)}) {
      const OddCells& odd = cells.columns[c];
      // What no frame has is a missing channel.
      const bool is_missing = odd.words == 0 && (odd.marks == 0 || odd.marks == cells.rows);
      if (is_missing) continue;
      if (!worst || odd.first_line < cells.columns[*worst].first_line) worst = c;
    }
  }
  if (!worst) return;
  const OddCells& odd = cells.columns[*worst];
  const std::string place = source + ": line " + std::to_string(odd.first_line) + ", column " +
                            std::to_string(*worst + 1) + ": ";
  if (odd.words == 0) {
    throw InputError(place +
                     (odd.first.empty() ? "is empty" : "is not finite (\"" + odd.first + "\")") +
                     ", a value that was not measured; leave such frames out");
  }
  throw InputError(place + "must be a number, is \"" + odd.first + "\"");
}

/// What a table says beside its numbers.
struct Table {
  RowMajorMatrix rows;
  std::vector<std::array<int, 4>> channels;
  std::string unit;
  std::vector<std::string> notes;
};

/// Whether a protocol of 8, 12, ... 64 electrodes has so many channels: skipping the electrodes
/// that carry current or not, each pair once or in both orders.
bool is_usual_count(std::size_t channels) {
  return std::ranges::any_of(std::views::iota(2, 17), [&](int quarter) {
    const auto n = 4 * static_cast<std::size_t>(quarter);
    const auto is = [&](std::size_t count) { return channels == count || 2 * channels == count; };
    return is(n * (n - 3)) || is(n * (n - 1)) || channels == n * n;
  });
}

/// Whether a column before `following` others numbers the frames or has the seconds since the first
/// one, which never fall and are one more than a protocol has channels.
bool counts_up(const Cells& cells, std::size_t column, std::size_t following) {
  const auto values = matrix_of(cells).col(static_cast<Eigen::Index>(column)).array();
  if (values.size() < 3) return false;
  const auto steps = values.bottomRows(values.size() - 1) - values.topRows(values.size() - 1);
  if (values[0] == std::floor(values[0]) && (steps == 1).all()) return true;
  return (steps >= 0).all() && steps.maxCoeff() > 0 && is_usual_count(following) &&
         !is_usual_count(following + 1);
}

/// Whether a column has the time of each frame, in text or in seconds of a clock.
bool is_stamp(const Cells& cells, std::size_t column) {
  const OddCells& odd = cells.columns[column];
  const bool is_date = odd.first.find_first_of("0123456789") != std::string::npos &&
                       odd.first.find_first_of(":/-") != std::string::npos;
  const bool is_label = odd.first.find_first_of("[{(=") == std::string::npos;
  if (odd.words == cells.rows) return is_date || (is_label && cells.rows > 1);
  constexpr double least_seconds = 1e6;
  const auto values = matrix_of(cells).col(static_cast<Eigen::Index>(column)).array();
  return odd.words + odd.marks == 0 && (values > least_seconds).all();
}

std::string column_text(const Cells& cells, std::size_t column) {
  std::string text = "column " + std::to_string(column + 1);
  if (column < cells.titles.size() && !cells.titles[column].empty()) {
    text += " (\"" + printable(cells.titles[column], 40) + "\")";
  }
  return text;
}

/// The columns of the frames; those that are passed over are named in `notes`.
TitledColumns columns_of(const Cells& cells, const std::string& source,
                         std::vector<std::string>& notes) {
  const std::size_t count = cells.columns.size();
  std::vector<std::string_view> titles = cells.titles;
  if (titles.size() != count) titles.assign(count, "-");
  TitledColumns columns = titled_columns(titles, source);
  if (columns.channels.empty()) {
    std::vector<TitledColumns::Column>& used = columns.columns;
    std::erase_if(used, [&](const auto& column) { return is_stamp(cells, column.value); });
    while (!used.empty() && counts_up(cells, used.front().value, used.size() - 1)) {
      used.erase(used.begin());
    }
    // "POLAR 16 " before 256 values.
    if (!columns.columns.empty()) {
      const auto first = static_cast<Eigen::Index>(columns.columns.front().value);
      const auto values = matrix_of(cells).col(first);
      if (counts_values(values[0], columns.columns.size() - 1) &&
          (values.array() == values[0]).all()) {
        columns.columns.erase(columns.columns.begin());
      }
    }
  }
  std::vector<std::size_t> left;
  for (std::size_t c = 0; c < count; ++c) {
    const auto uses = [&](const TitledColumns::Column& used) {
      return used.value == c || used.phase == c;
    };
    if (std::ranges::none_of(columns.columns, uses)) left.push_back(c);
  }
  if (left.size() == count) {
    throw InputError(source + ": holds no voltages: all of its " + std::to_string(count) +
                     " columns are counts, times or words");
  }
  std::string text = joined(std::span(left).first(std::min<std::size_t>(3, left.size())), ", ",
                            [&](std::size_t c) { return column_text(cells, c); });
  if (left.size() > 3) text += " and " + std::to_string(left.size() - 3) + " more";
  if (!left.empty()) notes.push_back(text + ": passed over, as no voltages of channels");
  return columns;
}

/// Turns magnitudes into voltages in phase, with their phases' signs.
void apply_phase(const Cells& cells, const TitledColumns& columns, const std::string& source,
                 RowMajorMatrix& rows) {
  const auto all = matrix_of(cells);
  double most = 0;
  bool is_near_half_turn = false;
  for (const TitledColumns::Column& column : columns.columns) {
    if (!column.phase) continue;
    const auto phases = all.col(static_cast<Eigen::Index>(*column.phase)).array().abs();
    most = std::max(most, phases.maxCoeff());
    is_near_half_turn = is_near_half_turn || ((phases - std::numbers::pi).abs() < 0.5).any();
  }
  const bool in_degrees =
      columns.phase_unit.empty() ? most > 2 * std::numbers::pi : columns.phase_unit == "deg";
  if (columns.phase_unit.empty() && !in_degrees && most > 0.2 && !is_near_half_turn) {
    throw InputError(source + ": phases of up to " + number_text(most) +
                     " may be degrees or radians; say it in the titles (\"Phase [deg]\")");
  }
  const double to_radians = in_degrees ? std::numbers::pi / 180 : 1;
  for (std::size_t c = 0; c < columns.columns.size(); ++c) {
    if (!columns.columns[c].phase) continue;
    const auto phases = all.col(static_cast<Eigen::Index>(*columns.columns[c].phase)).array();
    rows.col(static_cast<Eigen::Index>(c)).array() *= (to_radians * phases).cos();
  }
}

Table table_of(std::string_view text, const std::string& source) {
  const Cells cells = TextReader(source).read(text);
  Table table;
  const TitledColumns columns = columns_of(cells, source, table.notes);
  require_numbers(cells, columns.columns, source);
  const auto all = matrix_of(cells);
  table.rows.resize(all.rows(), static_cast<Eigen::Index>(columns.columns.size()));
  bool has_phase = false;
  for (std::size_t c = 0; c < columns.columns.size(); ++c) {
    has_phase = has_phase || columns.columns[c].phase;
    table.rows.col(static_cast<Eigen::Index>(c)) =
        all.col(static_cast<Eigen::Index>(columns.columns[c].value));
  }
  if (has_phase) apply_phase(cells, columns, source, table.rows);
  table.channels = columns.channels;
  table.unit = columns.unit;
  if (cells.format.decimal_comma) table.notes.emplace_back("the numbers have decimal commas");
  if (has_phase || cells.is_complex) {
    table.notes.emplace_back("the values are complex: their part in phase is taken");
  }
  if (!cells.prefix.empty()) {
    table.notes.push_back("the words before the numbers (\"" + printable(cells.prefix, 40) +
                          "\") were passed over");
  }
  if (cells.passed_lines > 1) {
    table.notes.push_back(std::to_string(cells.passed_lines) +
                          " lines without numbers before the first frame were passed over");
  }
  return table;
}

class CsvFrames final : public TableFrames {
 public:
  CsvFrames(const fs::path& input, const FrameFileOptions& options) : TableFrames(input) {
    if (!options.dataset.empty()) {
      throw InputError(path_.string() +
                       ": is read as text, which has no datasets; leave --dataset out");
    }
    const std::string text = utf8_text(text_of_file(path_), path_.string());
    if (options.transposed.value_or(false)) {
      rows_ = numbers_of_text(text, path_.string()).transpose();
    } else {
      table_ = table_of(text, path_.string());
      rows_ = std::move(table_.rows);
    }
  }

  std::string format() const override { return "CSV"; }
  std::vector<ChannelElectrodes> channels() const override {
    std::vector<ChannelElectrodes> out;
    for (const auto& [a, b, m, n] : table_.channels) out.push_back({{a, b}, {m, n}});
    return out;
  }
  std::string unit() const override { return table_.unit; }
  std::vector<std::string> notes() const override { return table_.notes; }

 private:
  Table table_;  ///< but for its rows
};

}  // namespace

RowMajorMatrix numbers_of_text(std::string_view text, const std::string& source) {
  const std::string plain = utf8_text(std::string(text), source);
  const Cells cells = TextReader(source).read(plain);
  std::vector<TitledColumns::Column> all(cells.columns.size());
  for (std::size_t c = 0; c < all.size(); ++c) all[c].value = c;
  require_numbers(cells, all, source);
  return matrix_of(cells);
}

std::unique_ptr<FrameSource> open_csv_frames(const fs::path& input,
                                             const FrameFileOptions& options) {
  return std::make_unique<CsvFrames>(input, options);
}

}  // namespace ertbench
