#include "solvers/nuisances.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "forward/border/border_model.h"
#include "forward/data/sheet_model.h"
#include "solvers/channel_mask.h"

namespace ertbench {
namespace {

/// Displacement of an electrode along the border, for finite differences.
constexpr double displacement = 1e-4;

}  // namespace

Nuisances Nuisances::from_json(JsonObject& parameters, const std::string& key) {
  Nuisances out;
  if (!parameters.has(key)) return out;
  JsonObject object = parameters.object(key);
  out.gain = object.number_or("gain", 0, {0, 10});
  out.level = object.number_or("level", 0, {0, 10});
  out.gradient = object.number_or("gradient", 0, {0, 10});
  out.electrodes = object.number_or("electrodes", 0, {0, 1});
  object.finish();
  return out;
}

void Nuisances::add_to(nlohmann::json& parameters, const std::string& key) const {
  if (!any()) return;
  parameters[key] = {
      {"gain", gain}, {"level", level}, {"gradient", gradient}, {"electrodes", electrodes}};
}

ParameterInfo Nuisances::parameter() {
  return {
      "nuisances",
      "unknowns beside the contacts, by their standard deviations: {\"gain\": relative, "
      "\"level\": of the whole sheet's conductivity, relative, \"gradient\": relative per domain "
      "unit, \"electrodes\": domain units}; default none"};
}

Eigen::MatrixXd Nuisances::responses(const Sensor& sensor) const {
  std::vector<Eigen::VectorXd> channels;
  const BorderModel model(sensor);
  if (factor() > 0) channels.push_back(factor() * model.reference_voltages());
  if (gradient > 0) {
    const PixelGrid pixels = sensor.image();
    const RowMajorMatrix jacobian = uniform_jacobian(sensor);
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::VectorXd slope(pixels.count());
      for (int p = 0; p < pixels.count(); ++p) {
        slope[p] = pixels.on_sheet(p) ? sensor.background * pixels.centre(p)[axis] : 0;
      }
      channels.push_back(gradient * (jacobian * slope));
    }
  }
  for (int e = 0; electrodes > 0 && e < sensor.electrode_count; ++e) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(sensor.electrode_count);
    moved[e] = displacement;
    channels.push_back(electrodes / (2 * displacement) *
                       (BorderModel(sensor, moved).reference_voltages() -
                        BorderModel(sensor, -moved).reference_voltages()));
  }
  Eigen::MatrixXd out(sensor.channels(), static_cast<Eigen::Index>(channels.size()));
  for (Eigen::Index c = 0; c < out.cols(); ++c) out.col(c) = channels[static_cast<std::size_t>(c)];
  return out;
}

Eigen::MatrixXd Nuisances::columns(const Sensor& sensor) const {
  return Reciprocity(sensor).reduce_rows(responses(sensor));
}

}  // namespace ertbench
