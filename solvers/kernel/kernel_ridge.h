#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "solvers/kernel/kernel_regression.h"
#include "solvers/kernel/position_models.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

class DatasetFile;

/// Kernel ridge regression, type "kernel-ridge": predicts position and strength of a press from the
/// voltages of known presses, without a model of the sheet or of its channels. By default changes
/// are compared by direction, which gives the position, and by the logarithm of their norm, which
/// gives the strength. Hyperparameters are chosen by leave-one-out, separately for position and
/// strength, so that no validation set is needed; if there is one, it is learned from as well.
///
/// "position": "likelihood" takes the position from PositionLikelihood in place of the regression,
/// "nearest" from NearestPresses.
///
/// A frame has one contact, or none if the predicted strength is below half of the least learned
/// one. The image is a disc at the position, with the mean size of the learned contacts and the
/// predicted strength.
class KernelRidge final : public Solver, public ContactFinder {
 public:
  static constexpr const char* type = "kernel-ridge";

  /// `{"position", "input", "width", "lambda", "norm_weight", "strength": {"width", "lambda",
  /// "norm_weight"}, "validation", "most_frames"}`
  explicit KernelRidge(JsonObject parameters);

  nlohmann::json parameters() const override;
  bool needs_training() const override { return true; }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  const ContactFinder* contact_finder() const override { return this; }
  void find_contacts(FramesView changes,
                     std::span<std::vector<FoundContact>> contacts) const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  /// Training data.
  struct Presses {
    RowMajorMatrix changes;     ///< [frames, channels] V
    Eigen::MatrixXd places;     ///< [frames with a contact, 2] domain units; these come first
    Eigen::VectorXd strengths;  ///< [frames] signed, S/m times squared domain units; 0: no contact
    double area = 0;            ///< mean of the contacts, squared domain units
  };

  void read(JsonObject parameters);
  void learn(const FitInput& input);
  void choose_position();
  /// Fits both models to the presses.
  void regress();
  /// Position (domain units) and signed strength of the contact in a frame.
  struct Press {
    Eigen::Vector2d place;
    double strength;
  };
  std::optional<Press> press_of(const Eigen::Ref<const Eigen::RowVectorXd>& change) const;

  enum class Position { regression, likelihood, nearest };

  Position position_ = Position::regression;
  KernelInput input_ = KernelInput::direction;
  KernelScaleChoice place_choice_;
  KernelScaleChoice strength_choice_;
  bool joins_validation_ = true;
  int most_frames_ = 2000;

  Sensor sensor_;
  Presses presses_;
  ChosenScales place_scales_;
  ChosenScales strength_scales_;
  double least_strength_ = 0;  ///< a weaker prediction is no contact
  LikelihoodScales likelihood_;
  int neighbours_ = 1;
  std::function<Eigen::Vector2d(const Eigen::RowVectorXd&)> place_;
  KernelRegression strength_;
};

/// The solvers of this room.
std::vector<SolverType> kernel_solvers();

}  // namespace ertbench
