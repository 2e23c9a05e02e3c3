#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "forward/border/ellipse_model.h"
#include "solvers/contacts/contact_atoms.h"
#include "solvers/contacts/contact_prior.h"

namespace ertbench {

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
    bool discs = false;  ///< no stretch was looked for: that of `precision` means nothing
  };
  struct Found {
    Result best;
    /// The next best number of contacts that was looked at; its evidence says with what weight.
    Result other;
    bool has_other = false;
    int iterations = 0;
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
    int work = 0;      ///< points of all iterations
    double scale = 1;  ///< of the whitening, for the model's error
  };

  /// `whitening` [pairs, pairs]: see ContactAtoms.
  ContactFit(const Sensor& sensor, const ContactPrior& prior, const Eigen::MatrixXd& whitening,
             const Options& options);

  /// `changes` [pairs] V: means of reciprocal pairs. Const and thread-safe.
  void fit(const Eigen::VectorXd& changes, Workspace& workspace, Found& found) const;
  /// The same begun at `start`, the contacts of the frame before: where these explain the frame, no
  /// other number of contacts is tried.
  void follow(const Eigen::VectorXd& changes, std::span<const EllipticContact> start,
              Workspace& workspace, Found& found) const;

  const Options& options() const { return options_; }
  const EllipseModel& model() const { return model_; }

 private:
  /// Misfit and gradient at these contacts; false where the model has no answer.
  struct Point;
  bool linearise(const Eigen::VectorXd& changes, std::span<const EllipticContact> contacts,
                 Workspace& workspace, Point& point) const;
  void set_weights(Workspace& workspace) const;
  bool derivatives_of(std::span<const EllipticContact> contacts, Workspace& workspace) const;
  /// The contacts a step away, or as much of it as leaves them apart.
  std::vector<EllipticContact> stepped(std::span<const EllipticContact> contacts,
                                       const Eigen::VectorXd& step, Workspace& workspace) const;
  void optimise(const Eigen::VectorXd& changes, std::vector<EllipticContact> contacts,
                int iterations, Workspace& workspace, Result& result) const;
  double log_evidence(double objective, const Eigen::MatrixXd& precision,
                      std::size_t contacts) const;
  void keep_inside(EllipticContact& contact) const;
  bool add_one(const Eigen::VectorXd& changes, const Result& from, Workspace& workspace,
               Result& out) const;
  bool drop_or_join(const Eigen::VectorXd& changes, Workspace& workspace, Found& found) const;

  EllipseModel model_;
  ContactPrior prior_;
  Options options_;
  Eigen::MatrixXd whitening_;
  double uniform_noise_ =
      0;  ///< 1 / the whitening where that is a multiple of the identity, else 0
  ContactAtoms atoms_;
};

}  // namespace ertbench
