#include "solvers/contacts/contact_atoms.h"

#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int places = 15;  ///< along a side of the sheet's bounds
constexpr double atom_ratio = 0.5;
constexpr double largest_dipole = 0.9;  ///< |1 - f| / (1 + f) that a start may have

double dipole_of(double ratio) { return (1 - ratio) / (1 + ratio); }

}  // namespace

ContactAtoms::ContactAtoms(const EllipseModel& model, const MatrixXd& whitening) {
  const Sheet& sheet = *model.sensor().sheet;
  const Eigen::AlignedBox2d& box = sheet.bounds();
  const double shorter = box.sizes().minCoeff() / 2;
  EllipseModel::Workspace workspace;
  std::vector<VectorXd> rows;
  VectorXd change(model.pairs());
  for (const double radius : {0.08, 0.16, 0.3}) {
    for (int i = 0; i < places; ++i) {
      for (int j = 0; j < places; ++j) {
        EllipticContact atom;
        atom.log_size = std::log(radius * shorter);
        atom.log_ratio = std::log(atom_ratio);
        // From border to border, as far as a disc of this size may go.
        const Eigen::Vector2d part(i / (places - 1.0), j / (places - 1.0));
        const double margin = (1.02 * radius + 0.01) * shorter;
        atom.centre =
            box.min().array() + margin + part.array() * (box.sizes().array() - 2 * margin);
        if (!model.place(std::span(&atom, 1), workspace)) continue;
        model.evaluate(workspace, change);
        contacts_.push_back(atom);
        rows.emplace_back(whitening * change);
      }
    }
  }
  atoms_.resize(static_cast<Index>(rows.size()), model.pairs());
  for (Index k = 0; k < atoms_.rows(); ++k) {
    atoms_.row(k) = rows[static_cast<std::size_t>(k)].cast<float>();
  }
  squares_ = atoms_.cwiseAbs2();
}

void ContactAtoms::best(const VectorXd& residual, const VectorXd& weights, int count,
                        const ContactPrior& prior, std::vector<Start>& out) const {
  out.clear();
  thread_local Eigen::VectorXf weight;
  thread_local Eigen::VectorXf products;
  thread_local Eigen::VectorXf norms;
  thread_local Eigen::VectorXf squares;
  weight = weights.cwiseAbs2().cast<float>();
  norms.noalias() = squares_ * weight;
  weight.array() *= residual.cast<float>().array();
  products.noalias() = atoms_ * weight;
  squares = products.cwiseAbs2().cwiseQuotient(norms);
  // Atoms are falls: a product below zero is a rise.
  if (!prior.may_rise) squares = (products.array() > 0).select(squares, 0);
  if (!prior.may_fall) squares = (products.array() < 0).select(squares, 0);
  while (static_cast<int>(out.size()) < count) {
    Index k = 0;
    const double square = squares.maxCoeff(&k);
    if (square <= 0) return;
    Start start{contacts_[static_cast<std::size_t>(k)], square / 2};
    const double amplitude = products[k] / norms[k];
    const double dipole =
        std::clamp(amplitude * dipole_of(atom_ratio), -largest_dipole, largest_dipole);
    start.contact.log_ratio = std::log((1 - dipole) / (1 + dipole));
    out.push_back(start);
    const double apart = std::max(0.15, std::exp(start.contact.log_size) / 2);
    for (Index other = 0; other < squares.size(); ++other) {
      const Eigen::Vector2d step =
          contacts_[static_cast<std::size_t>(other)].centre - start.contact.centre;
      if (step.squaredNorm() < apart * apart) squares[other] = 0;
    }
  }
}

}  // namespace ertbench
