#include "solvers/contacts/nuisances.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "forward/border/border_model.h"
#include "forward/data/uniform_sheet.h"
#include "solvers/reciprocity.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of an electrode along the border, for the difference that stands for a derivative.
constexpr double displacement = 1e-4;

VectorXd means(const Reciprocity& reciprocity, const VectorXd& channels) {
  return reciprocity.reduce(channels.transpose()) /
         (reciprocity.single() ? 1 : std::numbers::sqrt2);
}

}  // namespace

Nuisances Nuisances::from_json(JsonObject& parameters) {
  Nuisances out;
  if (!parameters.has("nuisances")) return out;
  JsonObject object = parameters.object("nuisances");
  out.gain = object.number_or("gain", 0, {0, 10});
  out.level = object.number_or("level", 0, {0, 10});
  out.gradient = object.number_or("gradient", 0, {0, 10});
  out.electrodes = object.number_or("electrodes", 0, {0, 1});
  object.finish();
  return out;
}

void Nuisances::add_to(nlohmann::json& parameters) const {
  if (!any()) return;
  parameters["nuisances"] = {
      {"gain", gain}, {"level", level}, {"gradient", gradient}, {"electrodes", electrodes}};
}

MatrixXd whitening_of(const Sensor& sensor, double noise, const Nuisances& nuisances) {
  const Reciprocity reciprocity(sensor);
  const Index pairs = reciprocity.pairs();
  const double averaged = reciprocity.single() ? 1 : 2;  // channels in a mean
  if (!nuisances.any()) return MatrixXd::Identity(pairs, pairs) * (std::sqrt(averaged) / noise);
  MatrixXd covariance = MatrixXd::Identity(pairs, pairs) * (noise * noise / averaged);
  const auto add = [&](const VectorXd& channels, double deviation) {
    const VectorXd column = deviation * means(reciprocity, channels);
    covariance += column * column.transpose();
  };
  const BorderModel model(sensor);
  if (nuisances.factor() > 0) add(model.reference_voltages(), nuisances.factor());
  if (nuisances.gradient > 0) {
    const PixelGrid pixels = sensor.image();
    const RowMajorMatrix jacobian = uniform_jacobian(sensor);
    for (int axis = 0; axis < 2; ++axis) {
      VectorXd slope(pixels.count());
      for (int p = 0; p < pixels.count(); ++p) {
        slope[p] = pixels.on_sheet(p) ? sensor.background * pixels.centre(p)[axis] : 0;
      }
      add(jacobian * slope, nuisances.gradient);
    }
  }
  if (nuisances.electrodes > 0) {
    for (int e = 0; e < sensor.electrode_count; ++e) {
      VectorXd moved = VectorXd::Zero(sensor.electrode_count);
      moved[e] = displacement;
      const BorderModel forth(sensor, moved);
      const BorderModel back(sensor, -moved);
      add((forth.reference_voltages() - back.reference_voltages()) / (2 * displacement),
          nuisances.electrodes);
    }
  }
  const Eigen::LLT<MatrixXd> factor(covariance);
  return factor.matrixL().solve(MatrixXd::Identity(pairs, pairs));
}

}  // namespace ertbench
