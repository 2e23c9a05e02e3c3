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

/// Bounds of contacts (EllipticContact, domain units): on the sheet, a small gap from its border,
/// with limited size and stretch. The border is a constraint on the steps of a fit, so that a
/// contact that touches it slides along; projecting it back after each step would converge slowly.
class ContactBounds {
 public:
  /// `ellipses`: false for contacts that are discs.
  ContactBounds(const Sheet& sheet, const ContactPrior& prior, bool ellipses);

  /// Projects a contact into the bounds.
  void keep_inside(EllipticContact& contact) const;

  /// The step s from `contacts` that minimises g's + 1/2 s'Hs, with `gradient` g [6 contacts] and
  /// the factored `curvature` H, and leaves no contact beyond the sheet's border: violated
  /// constraints are linearised at the violation and become equalities.
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
  /// No value if the whole contact is inside.
  std::optional<Nearest> outside(const EllipticContact& contact) const;

  const Sheet* sheet_;
  bool ellipses_;
  double longest_;  ///< EllipticContact::stretch
  double least_log_ratio_, largest_log_ratio_;
};

/// Most likely contacts of a frame: the maximum of
///
///     log p(contacts | voltages) = -1/2 |W (dv(contacts) - dv)|^2 + log prior + constants,
///
/// by Levenberg-Marquardt with exact derivatives. The number of contacts maximises the evidence in
/// Laplace's approximation: the posterior's maximum times the volume under its curvature, which
/// penalises the six parameters of each contact. Contacts are added one at a time, starting from
/// the best discs of a dictionary, and removed or merged if that increases the evidence.
class ContactFit {
 public:
  struct Options {
    bool ellipses = true;  ///< false: discs
    int most_contacts = 4;
    int most_iterations = 40;  ///< for one number of contacts
    /// Relative model error, since contacts are no ellipses: its root mean square over that of the
    /// frame. It counts as noise.
    double model_error = 0.02;
    double prior_weight = 1;  ///< multiplies the inverse variances of the prior
  };

  /// Maximum of the posterior for one number of contacts.
  struct Result {
    std::vector<EllipticContact> contacts;
    double misfit = 0;        ///< |W (dv(contacts) - dv)|^2
    double log_evidence = 0;  ///< up to a constant that does not depend on the number of contacts
    /// Inverse covariance of the posterior [6 contacts, 6 contacts] (Laplace).
    Eigen::MatrixXd precision;
    bool converged = true;
    bool settled = false;  ///< at the maximum to full accuracy, not stopped early as a trial
    bool discs = false;    ///< the stretch was not fitted; its entries of `precision` mean nothing
  };
  struct Found {
    Result best;
    /// The number of contacts with the next largest evidence, which gives its weight.
    Result other;
    bool has_other = false;
    int iterations = 0;
    /// Misfit of `best` when numbers of contacts were compared last, in this frame or an earlier
    /// one of the stream.
    double searched_misfit = 0;
  };

  /// Working memory of one thread.
  struct Workspace {
    EllipseModel::Workspace model;
    Eigen::VectorXd change, residual, whitened, weights;
    Eigen::MatrixXd derivatives, columns;
    /// [pairs] square root of the weight of each pair's misfit, 0 for a pair that is ignored;
    /// empty: all are 1. Set by the caller (set_kept).
    Eigen::VectorXd kept;
    /// [pairs, ignored pairs] where the whitening mixes pairs: directions of the whitened residual
    /// that ignored pairs reach. The residual is projected onto the rest, which leaves the
    /// likelihood of the other pairs alone; weights between 0 and 1 do not count.
    Eigen::MatrixXd ignored;
    std::vector<ContactAtoms::Start> starts;
    int iterations = 0;
    int work = 0;            ///< cost of all iterations, linear and quadratic in the points
    double unexplained = 0;  ///< misfit without a contact, before `scale`
    bool coarse = false;     ///< fewer points, while starts are tried
    double scale = 1;        ///< factor on the whitening for the model error
  };

  /// `whitening` [pairs, pairs]: see ContactAtoms.
  ContactFit(const Sensor& sensor, const ContactPrior& prior, const Eigen::MatrixXd& whitening,
             const Options& options);

  /// `changes` [pairs] V: means of reciprocal pairs. Const and thread-safe.
  void fit(const Eigen::VectorXd& changes, Workspace& workspace, Found& found) const;
  /// As `fit`, starting from the contacts `last` of the frame before, which may be those of
  /// `found`. If they explain this frame about as well as contacts did when numbers were last
  /// compared, and all of them are still needed, no other number is tried. `found` comes from the
  /// frame before.
  void follow(const Eigen::VectorXd& changes, const Result& last, Workspace& workspace,
              Found& found) const;

  /// Whitened residual [pairs] of a frame under these contacts; under no contacts if the model
  /// cannot place them.
  Eigen::VectorXd whitened_residual_of(const Eigen::VectorXd& changes,
                                       std::span<const EllipticContact> contacts,
                                       Workspace& workspace) const;

  /// Weights of the pairs of the next frame, see Workspace::kept.
  void set_kept(const Eigen::VectorXd& kept, Workspace& workspace) const;

  const Options& options() const { return options_; }
  const EllipseModel& model() const { return model_; }

 private:
  /// Budget of a frame in units of Workspace::work.
  static constexpr int most_work = 2000;
  struct Point;
  /// Stopping rule of `optimise`.
  struct Effort {
    int iterations = 0;
    /// Stops after a step that gains less than this share of the excess misfit.
    double looseness = 0;
    /// Stops if the evidence will not reach this.
    double least_evidence = -std::numeric_limits<double>::infinity();
  };
  /// Number of pairs by their weights.
  double pairs_in_use(const Workspace& workspace) const {
    return workspace.kept.size() > 0 ? workspace.kept.squaredNorm()
                                     : static_cast<double>(model_.pairs());
  }
  /// `whitened` [pairs, any]
  template <typename Matrix>
  static void project(const Workspace& workspace, Matrix& whitened) {
    if (workspace.ignored.size() == 0) return;
    whitened -= workspace.ignored * (workspace.ignored.transpose() * whitened).eval();
  }
  /// Multiplies the weights by those of the pairs; ignored ones are projected out instead.
  static void weigh_pairs(Workspace& workspace);
  void begin(const Eigen::VectorXd& changes, Workspace& workspace) const;
  const EllipseModel& model_in_use(const Workspace& workspace) const {
    return workspace.coarse ? coarse_ : model_;
  }
  /// Residual of the contacts that were placed last.
  void whitened_residual(const Eigen::VectorXd& changes, Workspace& workspace) const;
  /// Misfit and prior at the contacts, without derivatives; linearise adds those.
  void measure(const Eigen::VectorXd& changes, std::span<const EllipticContact> contacts,
               Workspace& workspace, Point& point) const;
  void linearise(Workspace& workspace, Point& point) const;
  void set_weights(Workspace& workspace) const;
  /// Places the contacts a step away, shortened until they do not overlap; false if no part of the
  /// step achieves that.
  bool step_to(std::span<const EllipticContact> contacts, const Eigen::VectorXd& step,
               Workspace& workspace, std::vector<EllipticContact>& next) const;
  void optimise(const Eigen::VectorXd& changes, std::vector<EllipticContact> contacts,
                const Effort& effort, Workspace& workspace, Result& result) const;
  double log_evidence(double objective, const Eigen::MatrixXd& precision,
                      std::size_t contacts) const;
  /// True if removing any of the contacts makes the misfit notably worse.
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
  double uniform_noise_ = 0;  ///< V, if the whitening is a multiple of the identity; else 0
  ContactAtoms atoms_;
};

}  // namespace ertbench
