#include "bench/ktc2023/ktc_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "core/errors.h"
#include "core/text.h"
#include "frames/matlab_matrix.h"

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

}  // namespace ertbench
