// Solvers that fail in every way a trial must survive.

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "forward/json_reader.h"
#include "solvers/registry.h"

namespace {

using namespace ertbench;

class Misbehaving final : public Solver {
 public:
  explicit Misbehaving(JsonObject object) : how_(object.text("how")) { object.finish(); }

  nlohmann::json parameters() const override { return {{"how", how_}}; }
  void fit(const FitInput&) override {
    if (how_ == "crash") std::abort();
    if (how_ == "throw") throw std::runtime_error("the matrix is on fire");
    if (how_ == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
  }
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override {
    images.setZero();
    for (Eigen::Index i = 0; i < changes.rows(); ++i) {
      if (how_ == "nan" && i % 2 == 0) images(i, 5) = std::numeric_limits<double>::quiet_NaN();
      if (how_ == "stops") reports[static_cast<std::size_t>(i)].status = FrameStatus::not_converged;
    }
  }
  void save(const std::filesystem::path& file) const override { std::ofstream(file) << how_; }
  void load(const std::filesystem::path&, const Sensor&) override {}

 private:
  std::string how_;
};

}  // namespace

extern "C" int ertbench_solver_interface() { return solver_interface_version; }
extern "C" void ertbench_register_solvers(SolverRegistry& registry) {
  registry.add("misbehaving", {"fails as it is told",
                               {{"how", "crash, throw, hang, nan or stops"}},
                               [](JsonObject object) -> std::unique_ptr<Solver> {
                                 return std::make_unique<Misbehaving>(object);
                               }});
}
