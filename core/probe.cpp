#include "core/probe.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/build.h"
#include "core/build_stamp.h"
#include "core/checksum.h"
#include "core/files.h"
#include "core/json.h"
#include "core/random.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// As it is written and read again: nine digits are far below any tolerance.
double shortened(double value) { return std::strtod(with_digits(value, 9).c_str(), nullptr); }

std::map<std::string, Probe>& memory() {
  static std::map<std::string, Probe> probes;
  return probes;
}

fs::path file_of(const std::string& name) {
  static const std::string program = stamp_of_this_build().program;
  std::string file = name;
  std::replace(file.begin(), file.end(), '/', '-');
  return cache_folder() / "probes" / program / (file + ".json");
}

std::optional<Probe> read_probe(const std::string& name) {
  try {
    json content = read_json_file(file_of(name));
    if (!take_checksum(content).empty() || content.at("name") != name) return std::nullopt;
    return Probe{content.at("numbers"), content.at("tolerance")};
  } catch (const std::exception&) {
    return std::nullopt;  // not there, or damaged
  }
}

/// Programs of long ago leave a few kilobytes each.
void remove_old_programs(const fs::path& folder) {
  constexpr std::chrono::hours age{24 * 30};
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const auto written = fs::last_write_time(entry.path(), ignored);
    if (ignored || fs::file_time_type::clock::now() - written < age) continue;
    fs::remove_all(entry.path(), ignored);
  }
}

void keep(const std::string& name, const Probe& probe) {
  const fs::path file = file_of(name);
  json content = {{"name", name}, {"numbers", probe.numbers}, {"tolerance", probe.tolerance}};
  add_checksum(content);
  try {
    if (fs::create_directories(file.parent_path())) {
      remove_old_programs(file.parent_path().parent_path());
    }
    write_file_atomically(file, json_text(content));
  } catch (const std::exception&) {  // a full or read-only disk
  }
}

}  // namespace

void Probe::add(const Eigen::Ref<const Eigen::VectorXd>& values) {
  for (std::size_t i = 0; i < projections; ++i) {
    RandomStream random(key_of("probe"), i, 0, Purpose::scene);
    double sum = 0;
    for (const double value : values) sum += value * random.normal();
    numbers.push_back(shortened(sum));
  }
}

double difference(const Probe& made, const Probe& now) {
  if (made.numbers.size() != now.numbers.size()) return infinite;
  double worst = 0;
  for (std::size_t first = 0; first < now.numbers.size(); first += Probe::projections) {
    const std::size_t last = std::min(first + Probe::projections, now.numbers.size());
    double norm = 0;
    double largest = 0;
    for (std::size_t i = first; i < last; ++i) {
      if (!std::isfinite(made.numbers[i]) || !std::isfinite(now.numbers[i])) return infinite;
      norm = std::hypot(norm, now.numbers[i]);
      largest = std::max(largest, std::abs(made.numbers[i] - now.numbers[i]));
    }
    if (largest > 0) worst = std::max(worst, norm > 0 ? largest / norm : infinite);
  }
  return worst;
}

/// Null where there is none. What was made before "front" was recorded has the one that is kept.
static const Probe* recorded_probe(const Probes& made, const std::string& name) {
  const Probes& in = name == "front" && !made.contains(name) ? release_probes() : made;
  const auto found = in.find(name);
  return found == in.end() ? nullptr : &found->second;
}

std::string probe_difference(const Probes& recorded, const Probes& now) {
  const Probes& made = recorded.empty() ? release_probes() : recorded;
  std::string out;
  for (const auto& [name, probe] : now) {
    const Probe* const found = recorded_probe(made, name);
    std::string how;
    if (!found) {
      how = "was not recorded";
    } else if (const double by = difference(*found, probe); by > probe.tolerance) {
      how = std::isinf(by) ? "has other numbers"
                           : "differs by " + with_digits(by, 2) + " of its norm";
    }
    if (!how.empty()) out += (out.empty() ? "the probe " : ", the probe ") + name + " " + how;
  }
  return out;
}

json to_json(const Probes& probes) {
  json out = json::object();
  for (const auto& [name, probe] : probes) out[name] = probe.numbers;
  return out;
}

Probes probes_from_json(const json& probes) {
  Probes out;
  for (const auto& [name, numbers] : probes.get_ref<const json::object_t&>()) {
    out[name].numbers = numbers.get<std::vector<double>>();
  }
  return out;
}

const Probes& release_probes() {
  static const Probes probes = probes_from_json(json::parse(this_build().release_probes));
  return probes;
}

bool has_cached_probe(const std::string& name) {
  if (memory().contains(name)) return true;
  const std::optional<Probe> probe = read_probe(name);
  if (probe) memory()[name] = *probe;
  return probe.has_value();
}

Probe cached_probe(const std::string& name, const std::function<Probe()>& compute) {
  if (!has_cached_probe(name)) {
    memory()[name] = compute();
    keep(name, memory()[name]);
  }
  return memory()[name];
}

}  // namespace ertbench
