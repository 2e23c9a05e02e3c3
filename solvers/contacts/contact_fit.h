#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "forward/border/contact_electrodes.h"
#include "forward/ellipses/ellipse_model.h"
#include "forward/sheet/sheet.h"
#include "solvers/contacts/contact_prior.h"
#include "solvers/contacts/contact_search.h"

namespace ertbench {

/// Where contacts (EllipticContact, domain units) may be: on the sheet, a hair from its border,
/// neither larger nor longer than any contact is. The border is a constraint on the steps of a fit.
/// A contact that touches it slides along; were it only put back after each step, it would come to
/// its best place in many small ones.
class ContactBounds {
 public:
  /// `ellipses`: false for contacts that are discs and stay so.
  ContactBounds(const Sheet& sheet, const ContactPrior& prior, bool ellipses);

  /// Puts a contact back to where it may be.
  void keep_inside(EllipticContact& contact) const;

  /// The step s from `contacts` that makes g's + 1/2 s'Hs least, `gradient` g [6 contacts] and the
  /// factored `curvature` H, and leaves no contact beyond the sheet's border: constraints that it
  /// would break are linearised where it breaks them, and hold with equality.
  Eigen::VectorXd step(std::span<const EllipticContact> contacts,
                       const Eigen::LLT<Eigen::MatrixXd>& curvature,
                       const Eigen::VectorXd& gradient) const;

 private:
  /// The point of a contact that is nearest to the sheet's border, or farthest beyond it.
  struct Nearest {
    Eigen::Vector2d point;    ///< from the contact's centre
    Eigen::Vector2d inwards;  ///< unit normal of the border there
    double depth = 0;
  };
  /// Nothing where all of the contact is inside.
  std::optional<Nearest> outside(const EllipticContact& contact) const;

  const Sheet* sheet_;
  bool ellipses_;
  double longest_;  ///< EllipticContact::stretch
  double least_log_ratio_, largest_log_ratio_;
};

/// The contacts that explain a frame best: the maximum of
///
///     log p(contacts | voltages) = -1/2 |W (dv(contacts) - dv)|^2 + log prior + constants,
///
/// by Levenberg-Marquardt with exact derivatives, as many contacts as the evidence asks for. The
/// evidence is Laplace's: the posterior's maximum times the volume under its curvature, so that a
/// contact has to earn the six numbers it brings. Contacts are added one at a time at the best
/// discs of a dictionary, and dropped or joined where the evidence is better without them.
class ContactFit {
 public:
  struct Options {
    bool ellipses = true;  ///< false: discs
    int most_contacts = 4;
    int most_iterations = 40;  ///< of one number of contacts
    /// Of contacts that are no ellipses, root mean square over that of the frame: counts as noise.
    double model_error = 0.02;
    double prior_weight = 1;  ///< multiplies the inverse variances of the prior
  };

  /// One number of contacts at the maximum of its posterior.
  struct Result {
    std::vector<EllipticContact> contacts;
    double misfit = 0;        ///< |W (dv(contacts) - dv)|^2
    double log_evidence = 0;  ///< up to what is the same for all numbers of contacts
    /// Of all parameters [6 contacts, 6 contacts]: inverse covariance of the posterior (Laplace).
    Eigen::MatrixXd precision;
    bool converged = true;
    bool settled = false;  ///< no further step would change anything, also what was a trial
    bool discs = false;    ///< no stretch was looked for: that of `precision` means nothing
  };
  struct Found {
    Result best;
    /// The next best number of contacts that was looked at; its evidence says with what weight.
    Result other;
    bool has_other = false;
    int iterations = 0;
    /// Of the best, when numbers of contacts were compared last: in this frame or one followed
    /// since.
    double searched_misfit = 0;
  };

  /// Memory of one thread.
  struct Workspace {
    EllipseModel::Workspace model;
    Eigen::VectorXd change, residual, whitened, weights;
    Eigen::MatrixXd derivatives, columns;
    /// [pairs] 1, or 0 for a pair that is left out of account; empty: all count. The caller's.
    Eigen::VectorXd kept;
    std::vector<ContactAtoms::Start> starts;
    int iterations = 0;
    int work = 0;            ///< of all iterations: points, and what goes with their square
    double unexplained = 0;  ///< misfit of no contact, before `scale`
    bool coarse = false;     ///< a start is tried, with fewer points
    double scale = 1;        ///< of the whitening, for the model's error
  };

  /// `whitening` [pairs, pairs]: see ContactAtoms.
  ContactFit(const Sensor& sensor, const ContactPrior& prior, const Eigen::MatrixXd& whitening,
             const Options& options);

  /// `changes` [pairs] V: means of reciprocal pairs. Const and thread-safe.
  void fit(const Eigen::VectorXd& changes, Workspace& workspace, Found& found) const;
  /// The same begun at what was found in the frame before, which may be that of `found`: where its
  /// contacts explain the frame, about as well as contacts did when their number was last looked
  /// for, and none of them has gone, no other number is tried. `found` is that of the frames
  /// before.
  void follow(const Eigen::VectorXd& changes, const Result& last, Workspace& workspace,
              Found& found) const;

  /// What these contacts leave of a frame, whitened [pairs]; of none where they have no voltages.
  Eigen::VectorXd whitened_residual_of(const Eigen::VectorXd& changes,
                                       std::span<const EllipticContact> contacts,
                                       Workspace& workspace) const;

  const Options& options() const { return options_; }
  const EllipseModel& model() const { return model_; }

 private:
  /// A frame gets so much and no more, in units of Workspace::work.
  static constexpr int most_work = 2000;
  struct Point;
  /// How far `optimise` goes.
  struct Effort {
    int iterations = 0;
    /// A step that gains less than this part of the misfit in excess is the last.
    double looseness = 0;
    /// A trial that will not come to this much is given up.
    double least_evidence = -std::numeric_limits<double>::infinity();
  };
  /// Pairs that are not left out of account.
  double pairs_in_use(const Workspace& workspace) const {
    return workspace.kept.size() > 0 ? workspace.kept.sum() : static_cast<double>(model_.pairs());
  }
  void begin(const Eigen::VectorXd& changes, Workspace& workspace) const;
  const EllipseModel& model_in_use(const Workspace& workspace) const {
    return workspace.coarse ? coarse_ : model_;
  }
  /// Of the contacts that were placed last.
  void whitened_residual(const Eigen::VectorXd& changes, Workspace& workspace) const;
  /// Misfit and prior there, and what these need no derivatives for; linearise adds the rest.
  void measure(const Eigen::VectorXd& changes, std::span<const EllipticContact> contacts,
               Workspace& workspace, Point& point) const;
  void linearise(Workspace& workspace, Point& point) const;
  void set_weights(Workspace& workspace) const;
  /// Places the contacts a step away, or as much of it as leaves them apart; false where there is
  /// no such part.
  bool step_to(std::span<const EllipticContact> contacts, const Eigen::VectorXd& step,
               Workspace& workspace, std::vector<EllipticContact>& next) const;
  void optimise(const Eigen::VectorXd& changes, std::vector<EllipticContact> contacts,
                const Effort& effort, Workspace& workspace, Result& result) const;
  double log_evidence(double objective, const Eigen::MatrixXd& precision,
                      std::size_t contacts) const;
  /// Whether the frame is explained worse without any one of the contacts.
  bool are_needed(const Eigen::VectorXd& changes, const Result& result, Workspace& workspace) const;
  bool add_one(const Eigen::VectorXd& changes, const Result& from, Workspace& workspace,
               Result& out) const;
  void drop_or_join(const Eigen::VectorXd& changes, Workspace& workspace, Found& found) const;

  EllipseModel model_;
  EllipseModel coarse_;
  ContactPrior prior_;
  Options options_;
  ContactBounds bounds_;
  Eigen::MatrixXd whitening_;
  double uniform_noise_ =
      0;  ///< 1 / the whitening where that is a multiple of the identity, else 0
  ContactAtoms atoms_;
};

}  // namespace ertbench
