// The file of a fitted solver, loaded by each of the built-in solvers as the registry makes them.
// One that is loaded reconstructs.

#include "core/json.h"
#include "solvers/registry/registry.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/small_sensor.h"

namespace ertbench {
namespace {

void reconstruct(const Solver& solver, const Sensor& sensor) {
  Frames changes = Frames::Zero(3, sensor.channels());
  changes.row(1).setConstant(1e-3);
  changes.row(2).setLinSpaced(-1e-2, 1e-2);
  Images images(changes.rows(), sensor.pixels());
  std::vector<FrameReport> reports(3);
  solver.reconstruct(changes, images, reports);
  for (Eigen::Index f = 0; f < images.rows(); ++f) {
    fuzzing::require(images.row(f).allFinite() ||
                         reports[static_cast<std::size_t>(f)].status == FrameStatus::undefined,
                     "an image that is not finite is not reported as undefined");
  }
}

}  // namespace
}  // namespace ertbench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  static SolverRegistry registry;
  const Sensor sensor = fuzzing::small_sensor();
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "solver.fitted");
  for (const char* type : {"tsvd", "one-step-gn", "pdipm", "lmmse", "gauss-newton", "contacts"}) {
    const nlohmann::json spec = {{"type", type}};
    const std::unique_ptr<Solver> solver = registry.make(JsonObject(spec, "", ""));
    if (fuzzing::accepted(file.string(), [&] { solver->load(file, sensor); })) {
      reconstruct(*solver, sensor);
    }
  }
  return 0;
}
