#include "bench/record/provenance.h"

#include <H5public.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <Eigen/Core>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/record/cache.h"
#include "core/build.h"
#include "core/build_stamp.h"

namespace ertbench {
namespace {

std::string joined(int a, int b, int c) {
  return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
}

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string host_name() {
  utsname system{};
  ::uname(&system);
  return system.nodename;
}

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const auto colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

nlohmann::json machine_provenance() {
  utsname system{};
  ::uname(&system);
  const BuildStamp build = stamp_of_this_build(this_build().record_code);
  return {{"commit", build.commit},
          {"dirty", build.dirty},
          {"program", build.program},
          {"host", system.nodename},
          {"system", std::string(system.sysname) + " " + system.release},
          {"cpu", cpu_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"compiler", "g++ " __VERSION__},
          {"libraries",
           {{"eigen", joined(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
            {"hdf5", joined(H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE)},
            {"nlohmann_json", joined(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                     NLOHMANN_JSON_VERSION_PATCH)}}},
          {"date", utc_now()}};
}

nlohmann::json provenance(const Experiment& experiment, int jobs, const DateRange& measured) {
  nlohmann::json seeds = nlohmann::json::object();
  nlohmann::json datasets = nlohmann::json::object();
  for (const DatasetSpec* spec : experiment.datasets()) {
    seeds[spec->name] = spec->seed;
    datasets[spec->name] = to_json(*spec);
  }
  nlohmann::json out = machine_provenance();
  out["rendered"] = out.at("date");
  if (!measured.last.empty()) {
    out["date"] = measured.last;
    out["measured"] = {{"first", measured.first}, {"last", measured.last}};
  }
  if (!experiment.overrides.empty()) out["set"] = experiment.overrides;
  out["threads"] = 1;
  out["jobs"] = jobs;
  out["seeds"] = seeds;
  out["datasets"] = datasets;
  return out;
}

}  // namespace ertbench
