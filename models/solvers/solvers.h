#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/json.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/lean_net.h"
#include "models/solvers/learned_solver.h"
#include "models/training/objective.h"
#include "solvers/parameter_choice.h"

/// The learned solvers: each reads its settings and makes its network and its objective.
namespace ertbench {

class FcnnSolver final : public LearnedSolver {
 public:
  static constexpr const char* type = "fcnn";
  explicit FcnnSolver(JsonObject object) : LearnedSolver(type, {}) {
    read_inference(object);
    read(std::move(object));
  }
  void check(const Sensor&) const override {}
  /// Large, because reading the weights dominates: there are no maps to keep in the cache.
  Eigen::Index block_frames() const override { return 256; }

 protected:
  bool batches_share_weights() const override { return true; }

 private:
  void visit(Fields& fields) override;
  std::shared_ptr<Network> make_network(const Sensor& sensor) const override;
  std::unique_ptr<Objective> make_objective(const FitInput& input) const override;

  std::vector<int> widths_{2304, 576, 576};
  bool relative_loss_ = false;  ///< RelativeError, else SquaredError
};

class DcnnSolver final : public LearnedSolver {
 public:
  static constexpr const char* type = "dcnn";
  explicit DcnnSolver(JsonObject object) : LearnedSolver(type, {}) { read(std::move(object)); }
  void check(const Sensor& sensor) const override;

 private:
  void visit(Fields& fields) override;
  std::shared_ptr<Network> make_network(const Sensor& sensor) const override;
  std::unique_ptr<Objective> make_objective(const FitInput& input) const override;

  std::array<int, 3> widths_{64, 128, 256};
  bool relative_loss_ = false;  ///< RelativeError, else SquaredError
};

class EitNnSolver final : public LearnedSolver {
 public:
  static constexpr const char* type = "eit-nn";
  explicit EitNnSolver(JsonObject object) : LearnedSolver(type, {}) { read(std::move(object)); }
  void check(const Sensor& sensor) const override;

 private:
  void visit(Fields& fields) override;
  std::shared_ptr<Network> make_network(const Sensor& sensor) const override;
  std::unique_ptr<Objective> make_objective(const FitInput& input) const override;

  std::vector<int> dense_widths(const Sensor& sensor) const;

  std::optional<std::vector<int>> dense_widths_;  ///< default: 2304, 576 and the image's pixels
  std::array<int, 2> channels_{32, 64};
  enum class Loss { blurred, mse, relative };
  Loss loss_ = Loss::blurred;  ///< squared error of a blurred target, SquaredError, RelativeError
  Tunable lambda_;             ///< regularisation of the blur
};

class DdErtSolver final : public LearnedSolver {
 public:
  static constexpr const char* type = "dd-ert";
  explicit DdErtSolver(JsonObject object)
      : LearnedSolver(type, {.batch = 16, .learning_rate = 4e-3, .freeze_statistics = 0.4}) {
    read(std::move(object));
  }
  void check(const Sensor& sensor) const override;

 private:
  void visit(Fields& fields) override;
  std::shared_ptr<Network> make_network(const Sensor& sensor) const override;
  void initialise(Network& network, const FitInput& input,
                  Standardisation& standardisation) const override;
  std::unique_ptr<Objective> make_objective(const FitInput& input) const override;

  GeneratorShape shape_;
  enum class Start { physics, lmmse, random };
  Start start_ = Start::physics;  ///< of the dense layer: regularised inverse, LinearEstimate
  bool train_dense_ = true;
  AdversarialSettings adversarial_;
};

class LeanNetSolver final : public LearnedSolver {
 public:
  static constexpr const char* type = "lean-net";
  explicit LeanNetSolver(JsonObject object)
      : LearnedSolver(type, {.epochs = 40, .batch = 32, .learning_rate = 4e-3, .slow_rate = 0.3}) {
    read(std::move(object));
  }
  void check(const Sensor& sensor) const override;

 private:
  void visit(Fields& fields) override;
  std::shared_ptr<Network> make_network(const Sensor& sensor) const override;
  void initialise(Network& network, const FitInput& input,
                  Standardisation& standardisation) const override;
  std::unique_ptr<Objective> make_objective(const FitInput& input) const override;

  LeanShape shape_;
  std::string start_from_;     ///< a fitted network whose weights the training starts from
  bool lmmse_ = true;          ///< the dense layer begins as the linear MMSE estimate
  bool relative_loss_ = true;  ///< RelativeError, else SquaredError
};

}  // namespace ertbench
