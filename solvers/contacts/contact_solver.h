#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solvers/channel_mask.h"
#include "solvers/contacts/contact_fit.h"
#include "solvers/contacts/contact_image.h"
#include "solvers/contacts/contact_prior.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// A solver whose unknowns are the contacts: ellipses or discs, as many as a frame demands, fitted
/// to its voltages with the exact model of the continuous sheet (ContactFit). Its images are drawn
/// from the contacts, which are also to be had themselves (contact_finder), with their standard
/// deviations. A frame that no contacts explain is suspect (FrameReason::unexplained), whatever it
/// looks like otherwise.
class ContactSolver final : public Solver, private ContactFinder {
 public:
  static constexpr const char* type = "contacts";

  /// `{"shape": "ellipse" | "disc", "most_contacts": 1 ... 8, "prior": "broad" | "training",
  /// "prior_weight": > 0 | "auto", "model_error": 0 ... 0.5, "noise": > 0 | "auto",
  /// "conductivity_ratio": [low, high], "image": "mean" | "most-likely", "nuisances": {...}}` and
  /// what ChannelMask reads.
  explicit ContactSolver(JsonObject parameters);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override;
  bool needs_training() const override { return learns_prior_; }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  MaskedChannels masked_channels() const override { return mask_; }
  const ContactFinder* contact_finder() const override { return this; }
  /// Each frame's contacts are looked for from those of the frame before.
  std::unique_ptr<FrameStream> open_stream() const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  void find_contacts(FramesView changes,
                     std::span<std::vector<FoundContact>> contacts) const override;
  void read(JsonObject parameters);
  void prepare(const Sensor& sensor);
  class Stream;

  /// One frame as it was fitted. All of it may serve the next frame.
  struct Fitted {
    ContactFit::Workspace workspace;
    ContactFit::Found found;
    double level = 0;  ///< see FrameReport::level
  };
  /// Whether all channels of a frame are numbers but for those of masked and `dead` electrodes.
  bool is_finite(const double* changes, ElectrodeSet dead) const;
  /// Fits one frame, a row of changes; `dead` electrodes are left out of account. `followed`: begun
  /// at what `fitted` holds of the frame before.
  void fit_frame(const double* changes, ElectrodeSet dead, bool followed, Fitted& fitted) const;
  /// Takes the factor that all voltages have in common, first guessed to be `factor`, out of the
  /// frame and fits it again, until it has none.
  void fit_factor(const Eigen::VectorXd& means, double factor, bool followed, Fitted& fitted) const;
  void draw(const Fitted& fitted, Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report) const;
  /// The strongest first.
  void list_contacts(const ContactFit::Found& found, std::vector<FoundContact>& out) const;
  /// Puts the ratio that is known into the prior.
  void know_ratio();
  void choose_prior_weight(const FitInput& input);
  /// The misfit above which a frame is unexplained, from frames of the validation set.
  void set_misfit_limit(const FitInput& input);

  ContactFit::Options options_;
  bool learns_prior_ = false;
  bool most_likely_ = false;
  std::optional<std::pair<double, double>> known_ratio_;  ///< both below 1 or both above
  Tunable prior_weight_;
  Tunable noise_;  ///< of a channel, V
  Nuisances nuisances_;
  ChannelMask mask_;
  std::optional<ParameterChoice> choice_;
  ContactPrior prior_;
  double misfit_limit_ = 0;  ///< of chi^2; 0: none known yet

  Sensor sensor_;
  std::vector<std::array<int, 2>> pairs_;
  std::vector<ElectrodeSet> electrodes_of_pairs_;
  Eigen::VectorXd reference_;           ///< [pairs] V, of the uniform sheet
  Eigen::VectorXd whitened_reference_;  ///< [pairs]
  std::unique_ptr<const ContactFit> fit_;
  std::unique_ptr<const ContactImage> image_;
};

/// The solvers of this room.
std::vector<SolverType> contact_solvers();

}  // namespace ertbench
