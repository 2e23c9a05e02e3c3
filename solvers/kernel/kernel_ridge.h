#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "solvers/kernel/kernel_regression.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

class DatasetFile;

/// Kernel ridge regression to a place, type "kernel-ridge": from the voltages of known presses to
/// the place of a new one, and its strength, without any model of the sheet or of its channels. The
/// direction of a frame's change tells the place, its norm the strength, so that by default the
/// changes are compared by their directions, with the logarithm of the norm beside them as far as
/// it helps. All scales are chosen by leave-one-out, for place and strength apart, so that it needs
/// no validation set; one that is there is learned from as well.
///
/// Every frame is taken to have one contact, unless its strength comes out under half of the least
/// that it has learned from. The image is a disc at the place, of the mean size of the learned
/// contacts and of the strength found.
class KernelRidge final : public Solver, public ContactFinder {
 public:
  static constexpr const char* type = "kernel-ridge";

  /// `{"input", "width", "lambda", "norm_weight", "strength": {"width", "lambda", "norm_weight"},
  /// "validation", "most_frames"}`
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
  /// What was learned from.
  struct Presses {
    RowMajorMatrix changes;     ///< [frames, channels] V
    Eigen::MatrixXd places;     ///< [frames with a contact, 2] domain units; these come first
    Eigen::VectorXd strengths;  ///< [frames] signed, S/m times squared domain units; 0: no contact
    double area = 0;            ///< mean of the contacts, squared domain units
  };

  void read(JsonObject parameters);
  void learn(const FitInput& input);
  /// Makes both regressions from the presses and scales.
  void regress();
  /// Place and signed strength of one frame; nothing where it holds no contact.
  struct Press {
    Eigen::Vector2d place;
    double strength;
  };
  std::optional<Press> press_of(const Eigen::Ref<const Eigen::RowVectorXd>& change) const;

  KernelInput input_ = KernelInput::direction;
  KernelScaleChoice place_choice_;
  KernelScaleChoice strength_choice_;
  bool joins_validation_ = true;
  int most_frames_ = 1000;

  Sensor sensor_;
  Presses presses_;
  ChosenScales place_scales_;
  ChosenScales strength_scales_;
  double least_strength_ = 0;  ///< under which there is no contact
  KernelRegression place_;
  KernelRegression strength_;
};

/// The solvers of this room.
std::vector<SolverType> kernel_solvers();

}  // namespace ertbench
