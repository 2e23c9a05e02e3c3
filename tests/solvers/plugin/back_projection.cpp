// The complete solver of solvers/solver.h, as a plugin.

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/json.h"
#include "forward/data/sheet_model.h"
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
  void fit(const FitInput& input) override { jacobian_ = uniform_jacobian(input.sensor); }
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

#if defined(ERTBENCH_TEST_INTERFACE)  // as plugins were before they said what they were built with
extern "C" int ertbench_solver_interface() { return ERTBENCH_TEST_INTERFACE; }
#else
ERTBENCH_SOLVER_PLUGIN
#endif

#ifdef ERTBENCH_TEST_ABORTS  // to be refused before anything of it has run
namespace {
[[maybe_unused]] const bool loaded = (std::abort(), true);
}
#endif

extern "C" void ertbench_register_solvers(ertbench::SolverRegistry& registry) {
  registry.add("back-projection", {"back projection",
                                   {{"gain", "> 0, default 1"}},
                                   [](JsonObject parameters) -> std::unique_ptr<Solver> {
                                     return std::make_unique<BackProjection>(std::move(parameters));
                                   }});
}
