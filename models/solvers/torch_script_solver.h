#pragma once

#include <torch/script.h>

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "core/json.h"
#include "solvers/solver.h"

namespace ertbench {

/// A module that was traced or scripted in PyTorch (torch.jit.save), channels -> pixels. Such a
/// file is code that runs when it is loaded. That happens only in `fit` and `load`, in the process
/// of a trial, never when the solver is made.
///
/// The module maps [frames, channels], float32 or float64, to [frames, pixels], [frames, rows,
/// columns] or [frames, 1, rows, columns], row 0 at y = -1. "input" selects its input: the change
/// dv of the voltages in V, or (dv - mean) / std. "output" describes its output: the change of the
/// conductivity in S/m, or the drop y = 1 - sigma / background.
///
/// The fitted file holds mean and std (`/mean`, `/std` [channels], V). The module is not copied;
/// its contents are part of the fit's key in the cache.
class TorchScriptSolver final : public Solver {
 public:
  static constexpr const char* type = "torchscript";
  /// Throws InputError if the file does not exist, without opening it.
  explicit TorchScriptSolver(JsonObject object);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override;
  bool needs_training() const override { return input_ == Input::training; }
  /// Throws InputError if the file is no such module, or its images have another shape.
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  Eigen::Index block_frames() const override { return 64; }
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  enum class Input { change, training, given };
  enum class Output { change, drop };

  /// One number for all channels, or a list.
  Eigen::RowVectorXd read_given(JsonObject& object, const char* key, bool positive) const;
  void open(const Sensor& sensor);
  torch::Tensor run(const torch::Tensor& frames) const;

  std::string file_;            ///< as the experiment has it
  std::filesystem::path path_;  ///< absolute
  Input input_ = Input::change;
  Output output_ = Output::change;
  bool float64_ = false;
  std::string place_;  ///< of the entry, for messages
  std::optional<int> seed_;

  Sensor sensor_;
  Eigen::RowVectorXd mean_;  ///< [channels], or one for all; V
  Eigen::RowVectorXd std_;   ///< likewise
  mutable torch::jit::Module module_;
};

}  // namespace ertbench
