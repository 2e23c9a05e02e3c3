// The complete solver of solvers/solver.h, as a plugin.

#include <nlohmann/json.hpp>

#include "core/json_reader.h"
#include "forward/fem/forward_model.h"
#include "solvers/registry/registry.h"

namespace {

using namespace ertbench;

class BackProjection final : public Solver {
 public:
  explicit BackProjection(JsonObject parameters)
      : gain_(parameters.number_or("gain", 1.0, Range::positive())) {
    parameters.finish();
  }
  nlohmann::json parameters() const override { return {{"gain", gain_}}; }
  void fit(const FitInput& input) override {
    jacobian_ = ForwardModel(input.sensor, input.sensor.image_grid).jacobian();
  }
  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport>) const override {
    images.noalias() = gain_ * changes * jacobian_;
  }
  void save(const std::filesystem::path&) const override {}
  void load(const std::filesystem::path&, const Sensor& sensor) override {
    FitInput input;
    input.sensor = sensor;
    fit(input);
  }

 private:
  double gain_;
  RowMajorMatrix jacobian_;
};

}  // namespace

extern "C" int ertbench_solver_interface() { return ERTBENCH_PLUGIN_INTERFACE; }

extern "C" void ertbench_register_solvers(ertbench::SolverRegistry& registry) {
  registry.add("back-projection", {"back projection",
                                   {{"gain", "> 0, default 1"}},
                                   [](JsonObject parameters) -> std::unique_ptr<Solver> {
                                     return std::make_unique<BackProjection>(std::move(parameters));
                                   }});
}
