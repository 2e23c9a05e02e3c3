#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ertbench {

/// Where one training run of a label left its log.
struct TrainingSource {
  std::string stem;             ///< "dd-ert.seed2"
  std::string title;            ///< "seed 2"; empty without seeds
  std::filesystem::path log;    ///< may not exist: not every solver is trained
  std::string parameters_json;  ///< in which "training": {"best_epoch"} may stand
};

/// Copies the logs of one label into `folder`/`stem`.csv and draws them as `folder`/`label`.svg and
/// .png. Does nothing where there is no log; one that cannot be read is named in a warning. Returns
/// whether there is a chart.
bool write_training_results(const std::string& label, const std::vector<TrainingSource>& sources,
                            const std::filesystem::path& folder);

}  // namespace ertbench
