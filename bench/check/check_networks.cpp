#include "bench/check/check_networks.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/check/tolerance.h"
#include "core/hdf5_file.h"
#include "core/json_reader.h"
#include "core/process.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr double time_limit_s = 120;

std::vector<fs::path> specifications(const fs::path& folder, const std::set<std::string>& types) {
  std::vector<fs::path> out;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(folder, absent)) {
    if (entry.path().extension() != ".json") continue;
    const nlohmann::json spec = read_json_file(entry.path());
    if (types.count(JsonObject(spec, entry.path().string(), "").text("type"))) {
      out.push_back(entry.path());
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// The largest relative difference of a frame's image, where both files have the same frames and
/// statuses; infinite where not.
double difference(const fs::path& before, const fs::path& now) {
  const Hdf5File a = Hdf5File::open(before);
  const Hdf5File b = Hdf5File::open(now);
  const auto shape = a.shape("/conductivity_change");
  const bool same = b.shape("/conductivity_change") == shape &&
                    a.read_vector("/status") == b.read_vector("/status");
  if (!same) return std::numeric_limits<double>::infinity();
  const RowMajorMatrix images = a.read_rows("/conductivity_change", 0, shape[0]);
  const RowMajorMatrix changes = b.read_rows("/conductivity_change", 0, shape[0]) - images;
  return (changes.rowwise().norm().array() / images.rowwise().norm().array()).maxCoeff();
}

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

}  // namespace

std::vector<CheckLine> compare_stored_networks(const fs::path& folder,
                                               const std::set<std::string>& types,
                                               const fs::path& out) {
  std::vector<CheckLine> lines;
  for (const fs::path& spec : specifications(folder, types)) {
    fs::create_directories(out);
    const std::string name = spec.stem().string();
    const fs::path images = out / (name + ".images.h5");
    const fs::path log = out / (name + ".log");
    fs::remove(images);
    ChildProcess process(
        {fs::read_symlink("/proc/self/exe").string(), "reconstruct", "--solver", spec.string(),
         "--input", (folder / "frames.h5").string(), "--output", images.string()},
        {log}, time_limit_s);
    CheckLine line{"stored " + name, "images", "0", "", "<= " + text_of(stored_image_tolerance),
                   Verdict::worse};
    if (process.wait().ok()) {
      const double change = difference(folder / (name + ".images.h5"), images);
      line.now = text_of(change);
      if (change <= stored_image_tolerance) line.verdict = Verdict::ok;
    } else {
      line.now = "failed; see " + log.string();
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace ertbench
