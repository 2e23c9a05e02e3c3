#include "bench/check/stored_images.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "core/hdf5_file.h"
#include "core/process.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr double time_limit_s = 120;

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

bool make_images(const StoredImages& images) {
  fs::create_directories(images.now.parent_path());
  fs::remove(images.now);
  ChildProcess process(
      {fs::read_symlink("/proc/self/exe").string(), "reconstruct", "--solver", images.spec.string(),
       "--input", images.frames.string(), "--output", images.now.string()},
      {images.log}, {time_limit_s});
  return process.wait().ok();
}

CheckLine compare_images(const StoredImages& images) {
  CheckLine line{images.row, "images", "0", "", text_of(images.most), Verdict::worse};
  if (!fs::exists(images.now)) {
    line.now = "failed; see " + images.log.string();
    return line;
  }
  if (!fs::exists(images.before)) {
    line.before = "-";
    line.verdict = Verdict::missing;
    return line;
  }
  const double change = difference(images.before, images.now);
  line.now = text_of(change);
  if (change <= images.most) line.verdict = Verdict::ok;
  return line;
}

void add_missing_images(const std::vector<std::string>& rows, std::vector<CheckLine>& lines) {
  for (const std::string& row : rows) {
    const bool there = std::any_of(lines.begin(), lines.end(),
                                   [&](const CheckLine& line) { return line.row == row; });
    if (!there) lines.push_back({row, "images", "-", "-", "", Verdict::missing});
  }
}

}  // namespace ertbench
