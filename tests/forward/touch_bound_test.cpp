#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "core/json.h"
#include "forward/data/scene_model.h"
#include "forward/touch/indenter.h"

namespace ertbench {
namespace {

using Eigen::Vector3d;

DatasetSpec spec_with(double snr_db) {
  Sensor sensor;
  sensor.skin = Skin{};
  nlohmann::json json = nlohmann::json::parse(
      R"({"count": 1, "grid": 24, "snr_basis": "absolute",
          "scenes": {"touches": 1, "indenters": [{"type": "flat"}], "force_N": 8}})");
  json["snr_db"] = snr_db;
  return dataset_spec_from_json(JsonObject(json, "test", ""), sensor, "test");
}

class TouchFit {
 public:
  explicit TouchFit(const DatasetSpec& spec) : spec_(spec), model_(spec.sensor, spec.model) {}

  const SceneModel& model() const { return model_; }

  Eigen::MatrixXd voltages(const std::vector<Touch>& touches) const {
    std::vector<Scene> scenes;
    for (const Touch& touch : touches) scenes.push_back(still_scene(spec_.sensor, {&touch, 1}));
    const std::vector<std::uint64_t> numbers(scenes.size(), 0);
    Frames out(static_cast<Eigen::Index>(scenes.size()), 208);
    RowMajorMatrix effort(out.rows(), 0);
    model_.solve(spec_, scenes, numbers, out, effort);
    return out.transpose();
  }

  /// The touch of the least squared residual near `start`: Gauss-Newton to convergence.
  Touch most_likely(Touch touch, const Eigen::VectorXd& frame) const {
    for (int iteration = 0; iteration < 6; ++iteration) {
      std::vector<Touch> around(4, touch);
      around[1].place_mm.x() += 0.05;
      around[2].place_mm.y() += 0.05;
      around[3].force_N += 0.02;
      const Eigen::MatrixXd v = voltages(around);
      Eigen::MatrixX3d jacobian(208, 3);
      jacobian << (v.col(1) - v.col(0)) / 0.05, (v.col(2) - v.col(0)) / 0.05,
          (v.col(3) - v.col(0)) / 0.02;
      const Vector3d step = jacobian.householderQr().solve(frame - v.col(0));
      touch.place_mm += step.head<2>();
      touch.force_N += step[2];
    }
    return touch;
  }

 private:
  const DatasetSpec& spec_;
  SceneModel model_;
};

TEST(TouchBound, IsTheScatterOfMaximumLikelihood) {
  // At 75 dB the estimate is as good as linear in the noise, and attains the bound.
  const DatasetSpec spec = spec_with(75);
  const TouchFit fit(spec);
  const Touch truth{Indenter{}, {23.1, -41.7}, 8};
  const Eigen::Matrix3d bound = touch_bound(spec, fit.model(), truth);
  const Eigen::VectorXd clean = fit.voltages({truth}).col(0);
  const int draws = 300;
  Eigen::MatrixX3d errors(draws, 3);
  for (int d = 0; d < draws; ++d) {
    RandomStream noise = spec.noise_stream(static_cast<std::uint64_t>(d));
    Eigen::VectorXd frame = clean;
    add_noise(spec.noise, fit.model().reference_voltages(), noise, frame);
    const Touch found = fit.most_likely(truth, frame);
    errors.row(d) << (found.place_mm - truth.place_mm).transpose(), found.force_N - truth.force_N;
  }
  for (int p = 0; p < 3; ++p) {
    // The standard deviation of 300 draws is known to 4 %: four of these.
    EXPECT_NEAR(std::sqrt(errors.col(p).squaredNorm() / draws) / std::sqrt(bound(p, p)), 1, 0.16)
        << p;
  }
}

TEST(TouchBound, HalvesWithSixDecibels) {
  const TouchFit fit(spec_with(50));
  const Touch touch{Indenter{}, {23.1, -41.7}, 8};
  const double loud = std::sqrt(touch_bound(spec_with(50), fit.model(), touch)(0, 0));
  const double quiet = std::sqrt(touch_bound(spec_with(70), fit.model(), touch)(0, 0));
  EXPECT_NEAR(loud / quiet, 10, 1e-9);
}

}  // namespace
}  // namespace ertbench
