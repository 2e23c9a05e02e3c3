#include "bench/check/check_networks.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/check/stored_images.h"
#include "bench/check/tolerance.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

std::string row_of(const std::string& name) { return "stored " + name; }

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

}  // namespace

std::vector<CheckLine> compare_stored_networks(const fs::path& folder,
                                               const std::set<std::string>& types,
                                               const std::vector<std::string>& expected,
                                               const fs::path& out) {
  std::vector<CheckLine> lines;
  for (const fs::path& spec : specifications(folder, types)) {
    const std::string name = spec.stem().string();
    const StoredImages images{row_of(name),
                              spec,
                              folder / "frames.h5",
                              folder / (name + ".images.h5"),
                              out / (name + ".images.h5"),
                              out / (name + ".log"),
                              stored_image_tolerance};
    make_images(images);
    lines.push_back(compare_images(images));
  }
  std::vector<std::string> rows;
  std::transform(expected.begin(), expected.end(), std::back_inserter(rows), row_of);
  add_missing_images(rows, lines);
  return lines;
}

std::vector<std::string> stored_networks(const fs::path& folder,
                                         const std::set<std::string>& types) {
  std::vector<std::string> names;
  for (const fs::path& spec : specifications(folder, types)) names.push_back(spec.stem().string());
  return names;
}

}  // namespace ertbench
