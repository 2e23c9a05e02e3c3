// The unified data format of BERT and pyGIMLi: electrodes, and a resistance for each channel.

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/errors.h"
#include "core/json.h"
#include "forward/sheet/sensor_json.h"
#include "frames/frame_source.h"
#include "frames/text_lines.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr double most_off =
    0.02;  ///< distance of an electrode from the border, of the sheet's size

/// The whole number that a line begins with, alone but for a comment: "16# Number of sensors".
std::optional<int> count_in(std::string_view line) {
  const std::vector<std::string_view> words =
      fields_of(line.substr(0, line.find('#')), {' ', false});
  bool is_complex = false;
  if (words.size() != 1) return std::nullopt;
  const auto value = number_of(words[0], {' ', false}, is_complex);
  if (!value || *value != std::floor(*value) || !(*value >= 0 && *value < 1e6)) return std::nullopt;
  return static_cast<int>(*value);
}

/// The lines of the file, without empty ones.
class UnifiedLines : public NumberedLines {
 public:
  using NumberedLines::NumberedLines;

  std::string_view next(const char* what) {
    while (const auto line = NumberedLines::next()) {
      if (!line->empty()) return *line;
    }
    fail(std::string("the file ends before ") + what);
  }
  int count(const char* what) {
    const auto count = count_in(next(what));
    if (!count || *count == 0) fail(std::string("must be ") + what);
    return *count;
  }
  /// The names of columns of a comment, without their units.
  std::vector<std::string> names(const char* what) {
    std::string_view line = next(what);
    if (!line.starts_with('#')) fail(std::string("must be \"#\" and ") + what);
    std::vector<std::string> out;
    for (const std::string_view word : fields_of(line.substr(1), {' ', false})) {
      out.emplace_back(word.substr(0, word.find('/')));
      std::transform(out.back().begin(), out.back().end(), out.back().begin(),
                     [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    }
    return out;
  }
  std::vector<double> numbers(std::size_t count, const char* what) {
    const std::string_view line = next(what);
    std::vector<double> out = NumberedLines::numbers(line.substr(0, line.find('#')));
    if (out.size() < count) {
      fail("has " + std::to_string(out.size()) + " numbers, the columns are " +
           std::to_string(count));
    }
    return out;
  }
};

/// Electrodes around the middle of the sheet, mm, and the sheet as a sensor's JSON says it.
nlohmann::json sheet_of(Eigen::Matrix2Xd points, const UnifiedLines& lines) {
  // A circle: |p|^2 = 2 c p + (r^2 - |c|^2), by least squares.
  const Eigen::Vector2d shift = points.rowwise().mean();
  points.colwise() -= shift;
  Eigen::MatrixXd rows(points.cols(), 3);
  rows << 2 * points.transpose(), Eigen::VectorXd::Ones(points.cols());
  const Eigen::Vector3d fit =
      rows.colPivHouseholderQr().solve(points.colwise().squaredNorm().transpose());
  const double radius = std::sqrt(std::max(0.0, fit[2] + fit.head<2>().squaredNorm()));
  const Eigen::Matrix2Xd around = points.colwise() - fit.head<2>();
  const Eigen::VectorXd off = (around.colwise().norm().array() - radius).abs();
  const Eigen::Vector2d low = points.rowwise().minCoeff();
  const Eigen::Vector2d size = points.rowwise().maxCoeff() - low;
  if (!(size.minCoeff() > 1e-3 * size.maxCoeff())) {
    lines.fail("the electrodes stand in a line; a sheet has them around its border");
  }
  nlohmann::json out;
  if (off.maxCoeff() <= most_off * radius && radius < 10 * size.maxCoeff()) {
    out = {{"shape", "disc"}, {"diameter_mm", 2e3 * radius}};
    points =
        around * (radius * around.colwise().norm().cwiseInverse().asDiagonal().toDenseMatrix());
  } else {
    out = {{"shape", "rectangle"}, {"sides_mm", {1e3 * size.x(), 1e3 * size.y()}}};
    points.colwise() -= low + size / 2;
    for (const auto& point : points.colwise()) {
      const Eigen::Vector2d inside = size / 2 - point.cwiseAbs();
      if (inside.minCoeff() > most_off * size.maxCoeff()) {
        lines.fail(
            "the electrodes stand neither on a circle nor on a rectangle; give another "
            "--sensor, with frames as a table");
      }
    }
  }
  for (const auto& point : points.colwise()) {
    out["electrode_points_mm"].push_back({1e3 * point.x(), 1e3 * point.y()});
  }
  return out;
}

class UnifiedFrames final : public TableFrames {
 public:
  UnifiedFrames(const fs::path& input, const FrameFileOptions& options) : TableFrames(input) {
    if (!options.dataset.empty() || options.transposed.value_or(false)) {
      throw InputError(path_.string() +
                       ": is one frame of BERT's format; leave --dataset and --transposed out");
    }
    file_ = parse_unified(text_of_file(path_), path_.string());
    rows_ = Eigen::Map<const Eigen::RowVectorXd>(file_.resistances.data(),
                                                 std::ssize(file_.resistances));
  }

  std::string format() const override { return "unified"; }
  std::optional<Sensor> sensor() const override { return file_.sensor; }
  bool knows_background() const override { return false; }
  std::vector<ChannelElectrodes> channels() const override { return file_.channels; }

 private:
  UnifiedFile file_;
};

}  // namespace

UnifiedFile parse_unified(std::string_view text, const std::string& source) {
  constexpr int most_electrodes = 1000;
  UnifiedLines lines(text, source);
  const int electrodes = lines.count("the number of electrodes");
  if (electrodes > most_electrodes) lines.fail("more than 1000 electrodes");
  const std::vector<std::string> axes = lines.names("the axes, \"x y\"");
  const auto x = std::ranges::find(axes, "x") - axes.begin();
  auto y = std::ranges::find(axes, "y") - axes.begin();
  if (y == std::ssize(axes)) y = std::ranges::find(axes, "z") - axes.begin();
  if (x == std::ssize(axes) || y == std::ssize(axes)) lines.fail("must name the axes, \"x y\"");
  Eigen::Matrix2Xd points(2, electrodes);
  for (int e = 0; e < electrodes; ++e) {
    const std::vector<double> place = lines.numbers(axes.size(), "all electrodes");
    points.col(e) << place[static_cast<std::size_t>(x)], place[static_cast<std::size_t>(y)];
  }
  const nlohmann::json sheet = sheet_of(points, lines);

  const int count = lines.count("the number of data");
  const std::vector<std::string> names = lines.names("the columns, \"a b m n r\"");
  const auto column = [&](const char* name) -> std::optional<std::size_t> {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names.begin());
  };
  const std::optional<std::size_t> pairs[] = {column("a"), column("b"), column("m"), column("n")};
  for (const auto& place : pairs) {
    if (!place) lines.fail("must name the columns a b m n");
  }
  const auto r = column("r"), u = column("u"), i = column("i"), k = column("k"),
             rhoa = column("rhoa"), valid = column("valid");
  if (!r && !(u && i) && !(rhoa && k)) {
    lines.fail("has no resistances: save r, or u and i, or rhoa and k");
  }
  UnifiedFile file;
  std::map<ChannelElectrodes, int> seen;
  for (int d = 0; d < count; ++d) {
    const std::vector<double> row = lines.numbers(names.size(), "all data");
    std::array<int, 4> at{};
    for (std::size_t p = 0; p < at.size(); ++p) {
      const double electrode = row[*pairs[p]];
      if (!(electrode >= 1 && electrode <= electrodes) || electrode != std::floor(electrode)) {
        lines.fail("electrodes are whole numbers from 1 to " + std::to_string(electrodes) +
                   "; poles (0) have no second electrode on a sheet");
      }
      at[p] = static_cast<int>(electrode) - 1;
    }
    if (std::set<int>(at.begin(), at.end()).size() != at.size()) {
      lines.fail("a b m n must be four electrodes");
    }
    const auto quotient = [&](std::size_t above, std::size_t below) {
      if (row[below] == 0) lines.fail(names[below] + " must not be 0");
      return row[above] / row[below];
    };
    const bool is_valid = !valid || row[*valid] != 0;
    const double resistance = !is_valid ? std::nan("")
                              : r       ? row[*r]
                              : u && i  ? quotient(*u, *i)
                                        : quotient(*rhoa, *k);
    if (is_valid && !(std::abs(resistance) < 1e12)) lines.fail("has no finite resistance");
    file.resistances.push_back(resistance);
    file.channels.push_back({{at[0], at[1]}, {at[2], at[3]}});
    if (!seen.emplace(file.channels.back(), d).second) lines.fail("is a channel that came before");
  }
  // In the format's own convention the current enters at a, in this program's at b.
  double agreement = 0;
  for (std::size_t c = 0; c < file.channels.size(); ++c) {
    const auto& [drive, measurement] = file.channels[c];
    if (std::isnan(file.resistances[c])) continue;
    const auto apart = [&](int one, int other) {
      return std::log((points.col(one) - points.col(other)).norm() + 1e-9);
    };
    agreement += file.resistances[c] *
                 (apart(measurement.first, drive.first) - apart(measurement.first, drive.second) -
                  apart(measurement.second, drive.first) + apart(measurement.second, drive.second));
  }
  if (agreement < 0) {
    for (double& resistance : file.resistances) resistance = -resistance;
  }
  if (count < 4 || count > 4096) lines.fail("a sensor has 4 to 4096 channels");
  file.sensor = with_channels(sensor_from_json(JsonObject(sheet, source, "")), file.channels);
  file.sensor.drive_current = 1;
  return file;
}

bool is_unified(std::string_view begin) {
  const std::size_t end = begin.find('\n');
  if (end == std::string_view::npos || !count_in(trimmed(begin.substr(0, end)))) return false;
  const std::string_view second =
      trimmed(begin.substr(end + 1, begin.find('\n', end + 1) - end - 1));
  return second.starts_with('#') && second.find('x') != std::string_view::npos;
}

std::unique_ptr<FrameSource> open_unified_frames(const fs::path& input,
                                                 const FrameFileOptions& options) {
  return std::make_unique<UnifiedFrames>(input, options);
}

}  // namespace ertbench
