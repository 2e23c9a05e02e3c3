#pragma once

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "core/checksum.h"
#include "tests/bench/small_experiment.h"

namespace ertbench::testing {

using nlohmann::json;

/// A folder with an experiment of its own copy of the toy solvers, so that they can be "rebuilt".
class CheckedExperiment {
 public:
  explicit CheckedExperiment(const std::string& name) : folder_("check_" + name) {
    fs::copy_file(ERTBENCH_MISBEHAVING_PLUGIN, folder_ / "libtoys.so");
    experiment = small_experiment();
    experiment["plugins"] = {"libtoys.so"};
    experiment["figure"] = {{"scenes", json::array()}};
    experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}},
                             {{"type", "misbehaving"}, {"how", "gain"}, {"label", "toy"}}};
  }
  ~CheckedExperiment() { ::unsetenv("TOY_GAIN"); }

  Outcome check(const std::string& options = "") {
    write_text(folder_ / "small.json", experiment.dump());
    return run_program(folder_.path(), "check small.json --baseline small.baseline " + options);
  }
  /// Gives the toy solvers another gain, and their library other bytes.
  void rebuild(const char* gain) {
    ::setenv("TOY_GAIN", gain, 1);
    write_text(folder_ / "libtoys.so", read_text(folder_ / "libtoys.so") + "\n");
  }
  json baseline() const { return json::parse(read_text(folder_ / "small.baseline")); }
  /// As `--update` would have written it.
  void set_baseline(json changed) {
    add_checksum(changed);
    write_text(folder_ / "small.baseline", changed.dump(2));
  }
  const TemporaryFolder& folder() const { return folder_; }

  json experiment;

 private:
  TemporaryFolder folder_;
};

inline bool contains(const Outcome& outcome, const std::string& text) {
  return outcome.output.find(text) != std::string::npos;
}

}  // namespace ertbench::testing
