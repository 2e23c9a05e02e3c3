#include "frames/contacts_entry.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "forward/data/sheet_model.h"

namespace ertbench {

void complete_contacts(nlohmann::json& entry, const Sensor& sensor,
                       const Eigen::VectorXd& reference, double relative_noise) {
  const auto is_open = [&](const char* key) {
    return entry.value(key, nlohmann::json("auto")) == "auto";
  };
  if (entry.value("type", "") != "contacts") return;
  if (is_open("prior_weight")) entry["prior_weight"] = 1;
  if (!is_open("noise") || !(relative_noise > 0)) return;
  const Eigen::VectorXd model = uniform_reference(sensor);
  entry["noise"] = relative_noise * model.norm() / std::sqrt(static_cast<double>(model.size()));
  const Eigen::VectorXd at_level = reference.dot(model) / model.squaredNorm() * model;
  const double misfit = (reference - at_level).norm() / reference.norm();
  if (!(misfit > 0.01)) return;  // a model made it
  if (!entry.contains("model_error")) entry["model_error"] = std::clamp(misfit, 0.02, 0.1);
  if (!entry.contains("nuisances")) {
    entry["nuisances"] = {{"level", 0.1}, {"gradient", 0.05}, {"electrodes", 0.01}};
  }
}

}  // namespace ertbench
