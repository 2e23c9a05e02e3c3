#include "bench/ktc2023/ktc_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>

#include "core/errors.h"
#include "core/text.h"
#include "frames/frame_source.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr int map_size = 256;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The first whole number of a text, -1 without one.
int number_in(const std::string& text) {
  const std::size_t begin = text.find_first_of("0123456789");
  if (begin == std::string::npos) return -1;
  return std::stoi(text.substr(
      begin, std::min<std::size_t>(6, text.find_first_not_of("0123456789", begin) - begin)));
}

/// 0 for a folder without a level in its name.
int level_of(const fs::path& file) {
  const std::string folder = lower(file.parent_path().filename().string());
  const std::size_t at = folder.find("level");
  return at == std::string::npos ? 0 : std::max(0, number_in(folder.substr(at)));
}

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw InputError(printable_path(file.string()) + ": " + what);
}

Eigen::MatrixXd matrix(const fs::path& file, const std::string& name, Eigen::Index rows) {
  const Eigen::MatrixXd out = read_matlab_matrix(file, name);
  if (out.rows() != rows) {
    fail(file, name + " must have " + std::to_string(rows) + " rows, it has " +
                   std::to_string(out.rows()) + "; is this a file of KTC2023?");
  }
  return out;
}

/// Neighbours, as all files of the competition have it.
Eigen::MatrixXd measuring_pairs(const fs::path& file) {
  const Eigen::MatrixXd out = matrix(file, "Mpat", TankModel::electrodes);
  if (!out.allFinite()) fail(file, "Mpat holds values that are not finite");
  return out;
}

KtcPatterns patterns_in(const fs::path& file, const std::string& currents) {
  KtcPatterns out{matrix(file, currents, TankModel::electrodes), measuring_pairs(file)};
  // Drives that were left out may be NaN; like those without a current they have no channels.
  out.currents = out.currents.unaryExpr([](double x) { return std::isfinite(x) ? x : 0; });
  if (out.currents.isZero(0)) fail(file, currents + " holds no current");
  return out;
}

Eigen::VectorXd voltages_in(const fs::path& file, const std::string& name,
                            const KtcPatterns& patterns) {
  const Eigen::MatrixXd out = read_matlab_matrix(file, name);
  if (out.size() != patterns.channels()) {
    fail(file, name + " has " + std::to_string(out.size()) + " values, the patterns have " +
                   std::to_string(patterns.channels()));
  }
  return out.reshaped();
}

ClassMap truth_in(const fs::path& file) {
  const Eigen::MatrixXd map = matrix(file, "truth", map_size);
  if (map.cols() != map_size || !map.allFinite() || map.minCoeff() < -0.5 || map.maxCoeff() > 2.5) {
    fail(file, "truth must be 256 x 256 of 0, 1 and 2");
  }
  return map.array().round().cast<int>();
}

/// Files by level (0: none) and number.
using Files = std::map<std::pair<int, int>, fs::path>;
struct Found {
  Files references, data, truths;
};

Found find_files(const fs::path& folder) {
  Found found;
  if (!fs::is_directory(folder)) fail(folder, "is no folder; name the folder of KTC2023's files");
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (!entry.is_regular_file() || lower(file.extension().string()) != ".mat") continue;
    const std::string stem = lower(file.stem().string());
    const std::pair key(level_of(file), number_in(stem));
    if (stem == "ref") found.references[{key.first, 0}] = file;
    if (key.second < 0) continue;
    if (stem.starts_with("data")) found.data[key] = file;
    if (stem.find("true") != std::string::npos || stem.find("truth") != std::string::npos) {
      found.truths[key] = file;
    }
  }
  if (found.references.empty()) fail(folder, "holds no ref.mat, the empty tank's measurement");
  if (found.data.empty()) fail(folder, "holds no measurement of a target, data1.mat");
  return found;
}

/// Weighted means along one side of an image, [size, size].
Eigen::MatrixXd window(Eigen::Index size, double width) {
  Eigen::MatrixXd out(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      const auto distance = static_cast<double>(i - j);
      out(i, j) = std::abs(distance) > std::ceil(2 * width)
                      ? 0
                      : std::exp(-distance * distance / (2 * width * width));
    }
    out.row(i) /= out.row(i).sum();
  }
  return out;
}

constexpr int bins = 256;

/// Sums over the histogram up to a bin, exclusively.
struct Histogram {
  std::array<double, bins + 1> count{};
  std::array<double, bins + 1> moment{};

  /// Share of a class's bins in the variance between classes, but for a constant.
  double between(int low, int high) const {
    const auto l = static_cast<std::size_t>(low);
    const auto h = static_cast<std::size_t>(high);
    const double n = count[h] - count[l];
    const double m = moment[h] - moment[l];
    return n > 0 ? m * m / n : -INFINITY;
  }
};

}  // namespace

KtcReference read_ktc_reference(const fs::path& file) {
  KtcReference out{patterns_in(file, "Injref"), {}};
  out.voltages = voltages_in(file, "Uelref", out.patterns);
  return out;
}

std::vector<KtcTarget> read_ktc_targets(const fs::path& folder) {
  const Found found = find_files(folder);
  std::vector<KtcTarget> targets;
  for (const auto& [key, file] : found.data) {
    const auto [level, number] = key;
    KtcTarget& target = targets.emplace_back();
    target.any_level = level == 0;
    target.level = std::max(1, level);
    if (level > 7) fail(file, "is of level " + std::to_string(level) + "; there are 1 to 7");
    target.name = (level == 0 ? "" : std::to_string(level) + ".") + std::to_string(number);
    const auto own = found.references.find({level, 0});
    target.reference = (own == found.references.end() ? found.references.begin() : own)->second;
    // Data files carry the pattern of measurements too; it is that of the empty tank.
    target.patterns = patterns_in(file, "Inj");
    target.voltages = voltages_in(file, "Uel", target.patterns);
    if (const auto truth = found.truths.find(key); truth != found.truths.end()) {
      target.truth = truth_in(truth->second);
    }
  }
  return targets;
}

double mean_similarity(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double width) {
  constexpr double c1 = 1e-4;
  constexpr double c2 = 9e-4;
  const Eigen::MatrixXd rows = window(a.rows(), width);
  const Eigen::MatrixXd columns = window(a.cols(), width).transpose();
  const auto mean = [&](const Eigen::ArrayXXd& image) -> Eigen::ArrayXXd {
    return (rows * image.matrix() * columns).array();
  };
  const Eigen::ArrayXXd in_a = mean(a.array());
  const Eigen::ArrayXXd in_b = mean(b.array());
  const Eigen::ArrayXXd variances =
      mean(a.array().square() + b.array().square()) - in_a.square() - in_b.square();
  const Eigen::ArrayXXd covariance = mean(a.array() * b.array()) - in_a * in_b;
  return ((2 * in_a * in_b + c1) * (2 * covariance + c2) /
          ((in_a.square() + in_b.square() + c1) * (variances + c2)))
      .mean();
}

double ktc_score(const ClassMap& truth, const ClassMap& map) {
  double sum = 0;
  for (const int kind : {1, 2}) {
    sum += mean_similarity((truth.array() == kind).cast<double>().matrix(),
                           (map.array() == kind).cast<double>().matrix());
  }
  return sum / 2;
}

ClassMap otsu_classes(const Eigen::MatrixXd& image) {
  const double low = image.minCoeff();
  const double step = (image.maxCoeff() - low) / bins;
  ClassMap out = ClassMap::Zero(image.rows(), image.cols());
  if (!(step > 0)) return out;
  Histogram sums;
  for (const double value : image.reshaped()) {
    const auto bin = static_cast<std::size_t>(std::clamp((value - low) / step, 0.0, bins - 1.0));
    sums.count[bin + 1] += 1;
    sums.moment[bin + 1] += static_cast<double>(bin);
  }
  for (std::size_t bin = 0; bin < bins; ++bin) {
    sums.count[bin + 1] += sums.count[bin];
    sums.moment[bin + 1] += sums.moment[bin];
  }
  double most = -INFINITY;
  std::array<double, 2> cuts{};
  for (int i = 1; i < bins; ++i) {
    for (int j = i + 1; j < bins; ++j) {
      const double value = sums.between(0, i) + sums.between(i, j) + sums.between(j, bins);
      if (value <= most) continue;
      most = value;
      cuts = {low + (i - 0.5) * step, low + (j - 0.5) * step};  // centres, as the organisers have
    }
  }
  const auto classes = image.unaryExpr(
      [&](double value) { return (value >= cuts[0]) + static_cast<int>(value >= cuts[1]); });
  std::array<Eigen::Index, 3> sizes{};
  for (int c = 0; c < 3; ++c) sizes[static_cast<std::size_t>(c)] = (classes.array() == c).count();
  const auto water = static_cast<int>(std::ranges::max_element(sizes) - sizes.begin());
  return classes.unaryExpr([&](int c) { return c == water ? 0 : c < water ? 1 : 2; });
}

}  // namespace ertbench
