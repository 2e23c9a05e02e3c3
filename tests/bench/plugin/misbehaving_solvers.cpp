// Solvers that fail in every way a trial must survive, and one that learns nothing at length.

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "core/json.h"
#include "solvers/registry/registry.h"

namespace {

using namespace ertbench;
using nlohmann::json;

/// Stands for what a change of the code changes.
double gain() {
  const char* const text = std::getenv("TOY_GAIN");
  return text ? std::atof(text) : 1;
}

/// No UTF-8, and what terminals, browsers and spreadsheets would obey.
const std::string hostile_text = "=1 \x1b[2J\x1b[31m \xff\xc2\x9b <script>alert(1)</script>";

class Misbehaving final : public Solver {
 public:
  explicit Misbehaving(JsonObject object) : how_(object.text("how")) { object.finish(); }

  nlohmann::json parameters() const override { return {{"how", how_}}; }
  void fit(const FitInput&) override {
    if (how_ == "crash") std::abort();
    if (how_ == "throw") throw std::runtime_error("the matrix is on fire");
    if (how_ == "throw hostile text") throw std::runtime_error(hostile_text);
    if (how_ == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
  }
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override {
    images.setConstant(how_ == "gain" ? -1e-3 * gain() : 0);
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

/// Stands for a network: has a seed, takes its time, tells how it gets on and leaves a log. Its
/// image is the same everywhere, the seed times `level`.
class ToyLearned final : public Solver {
 public:
  explicit ToyLearned(JsonObject object)
      : seed_(object.integer_or("seed", 1, 0, 2147483647)),
        level_(object.number_or("level", -1e-3)),
        offset_(object.number_or("offset", 0)),
        epochs_(object.integer_or("epochs", 4, 1, 1000)),
        epoch_s_(object.number_or("epoch_s", 0, {0, 10})),
        bad_seed_(object.integer_or("bad_seed", -1, -1, 1000)),
        how_(object.text_or("how", "crash")) {
    object.finish();
  }

  bool needs_training() const override { return how_ == "needs data"; }

  nlohmann::json parameters() const override {
    json out = {{"seed", seed_},
                {"level", level_},
                {"offset", offset_},
                {"training", {{"best_epoch", 1 + seed_ % epochs_}}}};
    if (is_bad("say hostile text")) out[hostile_text] = hostile_text;
    return out;
  }
  void fit(const FitInput& input) override {
    if (is_bad("crash")) std::abort();
    std::ofstream(input.work_folder.parent_path() / "fits", std::ios::app) << "fit\n";
    std::ofstream log(input.work_folder / "training.csv");
    log << "epoch,loss,content,validation_error,learning_rate,seconds\n";
    for (int epoch = 1; epoch <= epochs_; ++epoch) {
      std::this_thread::sleep_for(std::chrono::duration<double>(epoch_s_));
      log << epoch << ',' << 1.0 / (epoch + seed_) << ',' << 0.5 / (epoch + seed_) << ','
          << 0.4 + 0.1 / epoch << ",0.001," << epoch * epoch_s_ << "\n";
      if (input.progress) {
        input.progress(static_cast<std::uint64_t>(epoch), static_cast<std::uint64_t>(epochs_),
                       is_bad("say hostile text")
                           ? hostile_text
                           : "epoch " + std::to_string(epoch) + " of " + std::to_string(epochs_));
      }
    }
  }
  FitReport fit_report() const override {
    if (is_bad("diverge")) return {"diverged", "the loss rose to infinity"};
    if (is_bad("say hostile text")) return {hostile_text, hostile_text};
    return {};
  }
  void reconstruct(FramesView, ImagesView images, std::span<FrameReport> reports) const override {
    images.setConstant(gain() * (level_ * seed_ + offset_));
    if (is_bad("undefined")) reports.front().status = FrameStatus::undefined;
  }
  void save(const std::filesystem::path& file) const override { std::ofstream(file) << seed_; }
  void load(const std::filesystem::path&, const Sensor&) override {}

 private:
  bool is_bad(const std::string& how) const { return seed_ == bad_seed_ && how_ == how; }

  int seed_;
  double level_;
  double offset_;
  int epochs_;
  double epoch_s_;
  int bad_seed_;
  std::string how_;
};

}  // namespace

ERTBENCH_SOLVER_PLUGIN
extern "C" void ertbench_register_solvers(SolverRegistry& registry) {
  registry.add("misbehaving",
               {"fails as it is told",
                {{"how", "crash, throw, throw hostile text, hang, nan, stops or gain"}},
                [](JsonObject object) -> std::unique_ptr<Solver> {
                  return std::make_unique<Misbehaving>(object);
                }});
  registry.add("toy-learned",
               {"a constant image, learned at length",
                {{"seed", "0 ...", ParameterRole::seed},
                 {"level", "S/m"},
                 {"offset", "S/m"},
                 {"epochs", "1 ... 1000"},
                 {"epoch_s", "s"},
                 {"bad_seed", "with which it goes wrong"},
                 {"how", "crash, diverge, say hostile text, undefined or needs data"}},
                [](JsonObject object) -> std::unique_ptr<Solver> {
                  return std::make_unique<ToyLearned>(object);
                },
                ImageComparison::seeds});
}
