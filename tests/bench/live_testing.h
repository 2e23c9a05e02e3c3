#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "core/hdf5_file.h"
#include "tests/bench/running_program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench::testing {

/// A folder with an experiment (e.json), its test set (frames.h5) and a solver (gn.json).
class LiveFolder {
 public:
  explicit LiveFolder(const nlohmann::json& experiment = small_experiment()) : folder_("live") {
    write_text(folder_ / "e.json", experiment.dump());
    write_text(folder_ / "gn.json", R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.1})");
    const Outcome made =
        run_program(folder_.path(), "generate e.json --dataset test --out frames.h5");
    if (made.exit_code != 0) throw std::runtime_error(made.output);
    const Hdf5File file = Hdf5File::open(folder_ / "frames.h5");
    voltages = file.read_rows("/voltages", 0, 40);
  }

  const fs::path& path() const { return folder_.path(); }
  fs::path operator/(const std::string& name) const { return folder_ / name; }

  std::string binary(Eigen::Index frame) const {
    std::string bytes(sizeof(double) * static_cast<std::size_t>(voltages.cols()), '\0');
    std::memcpy(bytes.data(), voltages.row(frame).data(), bytes.size());
    return bytes;
  }
  std::string csv(Eigen::Index frame, const std::string& separator = ",") const {
    std::string line;
    for (const double value : voltages.row(frame)) {
      char text[32];
      std::snprintf(text, sizeof text, "%.17g", value);
      line.append(line.empty() ? "" : separator).append(text);
    }
    return line + "\n";
  }

  RowMajorMatrix voltages;  ///< [40, channels] V

 private:
  TemporaryFolder folder_;
};

/// The lines that are answers.
inline std::vector<nlohmann::json> answers_of(const std::vector<nlohmann::json>& lines) {
  std::vector<nlohmann::json> out;
  for (const nlohmann::json& line : lines) {
    if (line.contains("frame")) out.push_back(line);
  }
  return out;
}

/// Contacts of each answer, which tell images apart.
inline std::vector<nlohmann::json> contacts_of(const std::vector<nlohmann::json>& lines) {
  std::vector<nlohmann::json> out;
  for (const nlohmann::json& answer : answers_of(lines)) out.push_back(answer.at("contacts"));
  return out;
}

}  // namespace ertbench::testing
