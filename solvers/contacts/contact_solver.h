#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/channel_mask.h"
#include "solvers/contacts/contact_fit.h"
#include "solvers/contacts/contact_image.h"
#include "solvers/contacts/contact_prior.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// A solver whose unknowns are contacts, ellipses or discs, fitted to the voltages of a frame with
/// the exact model of the continuous sheet (ContactFit). It estimates their number, too. Images are
/// drawn from the contacts; contact_finder gives the contacts with their standard deviations. A
/// frame that no contacts explain is flagged (FrameReason::unexplained).
class ContactSolver final : public Solver, private ContactFinder {
 public:
  static constexpr const char* type = "contacts";

  /// `{"shape": "ellipse" | "disc", "most_contacts": 1 ... 8, "prior": "broad" | "training",
  /// "prior_weight": > 0 | "auto", "model_error": 0 ... 0.5, "noise": > 0 | "auto",
  /// "conductivity_ratio": [low, high], "image": "mean" | "most-likely", "likelihood": "normal" |
  /// "student", "nuisances": {...}}` and what ChannelMask reads.
  explicit ContactSolver(JsonObject parameters);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override;
  bool needs_training() const override { return learns_prior_; }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  MaskedChannels masked_channels() const override { return mask_; }
  const ContactFinder* contact_finder() const override { return this; }
  /// Each frame starts from the contacts of the frame before.
  std::unique_ptr<FrameStream> open_stream() const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  void find_contacts(FramesView changes,
                     std::span<std::vector<FoundContact>> contacts) const override;
  void read(JsonObject parameters);
  void prepare(const Sensor& sensor);
  class Stream;

  /// Fit of one frame, from which the next frame of a stream may start.
  struct Fitted {
    ContactFit::Workspace workspace;
    ContactFit::Found found;
    double level = 0;  ///< see FrameReport::level
  };
  /// True if all channels of a frame are finite, except those of masked and `dead` electrodes.
  bool is_finite(const double* changes, ElectrodeSet dead) const;
  /// Fits one frame [channels] without the `dead` electrodes. `followed`: starts from the fit of
  /// the frame before in `fitted`.
  void fit_frame(const double* changes, ElectrodeSet dead, bool followed, Fitted& fitted) const;
  /// Removes the factor common to all voltages, first guess `factor`, from the frame and fits
  /// again, until none is left.
  void fit_factor(const Eigen::VectorXd& means, double factor, bool followed, Fitted& fitted) const;
  void draw(const Fitted& fitted, Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report) const;
  /// Lists the contacts, the strongest first.
  void list_contacts(const ContactFit::Found& found, std::vector<FoundContact>& out) const;
  /// Enters the given conductivity ratio into the prior.
  void know_ratio();
  void choose_prior_weight(const FitInput& input);
  /// Sets the misfit above which a frame is unexplained, from frames of the validation set.
  void set_misfit_limit(const FitInput& input);

  ContactFit::Options options_;
  bool learns_prior_ = false;
  bool most_likely_ = false;
  bool student_ = false;                                  ///< "likelihood"
  std::optional<std::pair<double, double>> known_ratio_;  ///< both below 1 or both above
  Tunable prior_weight_;
  Tunable noise_;  ///< of a channel, V
  Nuisances nuisances_;
  ChannelMask mask_;
  ContactPrior prior_;
  double misfit_limit_ = 0;  ///< limit of chi^2; 0: not set

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
