#include "bench/ktc2023/tank_model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

using std::numbers::pi;

constexpr double first_end = 87.1875 / 180 * pi;  // angle at which the first electrode begins
constexpr int near_the_border = 4;                // rings as deep as half an electrode is wide
constexpr double half_width = pi / 64;            // of electrodes and of the gaps between them

Eigen::Matrix2d mass_of_segment(double length) {
  return (Eigen::Matrix2d() << length / 3, length / 6, length / 6, length / 3).finished();
}

/// Angles of a ring with nodes at the ends and the middles of electrodes and gaps, and at those
/// `parts` of the way from end to middle.
std::vector<double> graded_angles(const std::vector<double>& parts) {
  std::vector<double> out;
  for (int half = 0; half < 4 * TankModel::electrodes; ++half) {
    const double begin = first_end + half_width * half;
    out.push_back(begin);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double part = half % 2 == 0 ? parts[i] : 1 - parts[parts.size() - 1 - i];
      out.push_back(begin + half_width * part);
    }
  }
  return out;
}

/// Solves L L^T x = right for all electrodes at once, which is faster than one by one.
Eigen::MatrixXd solved(const Eigen::SparseMatrix<double>& lower, const Eigen::MatrixXd& right) {
  using Iterator = Eigen::SparseMatrix<double>::InnerIterator;
  Eigen::Matrix<double, Eigen::Dynamic, TankModel::electrodes, Eigen::RowMajor> x = right;
  for (Eigen::Index j = 0; j < x.rows(); ++j) {
    Iterator entry(lower, j);
    x.row(j) /= entry.value();
    while (++entry) x.row(entry.row()) -= entry.value() * x.row(j);
  }
  for (Eigen::Index j = x.rows() - 1; j >= 0; --j) {
    Iterator entry(lower, j);
    const double diagonal = entry.value();
    while (++entry) x.row(j) -= entry.value() * x.row(entry.row());
    x.row(j) /= diagonal;
  }
  return x;
}

std::vector<double> even_angles(int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(first_end + 2 * pi * i / count);
  return out;
}

}  // namespace

std::vector<TankModel::Ring> TankModel::rings(int refinement) {
  // Depths grow like distances from the electrodes' ends; nodes closer to an end are left behind.
  const int graded = near_the_border * refinement;
  const auto part = [&](int i) { return std::pow(static_cast<double>(i) / graded, 2); };
  std::vector<Ring> out;
  for (int i = 0; i <= graded; ++i) {
    std::vector<double> parts;
    for (int j = std::clamp(i, 1, graded - refinement + 1); j < graded; ++j)
      parts.push_back(part(j));
    out.push_back({1 - half_width * part(i), graded_angles(parts)});
  }
  // Inside, triangles grow as the resolution falls.
  const auto to = [&](double least, double step, int count) {
    while (out.back().radius - step / refinement > least) {
      out.push_back({out.back().radius - step / refinement, even_angles(count * refinement)});
    }
  };
  to(.57, .044, 128);
  to(.34, .08, 64);
  to(.05, .1, 32);
  out.push_back({0, even_angles(1)});
  for (std::size_t r = 1; r < out.size(); ++r) {
    out[r].first = out[r - 1].first + static_cast<int>(out[r - 1].angles.size());
  }
  return out;
}

void TankModel::add_triangles(const Ring& inner, const Ring& outer) {
  const auto node = [](const Ring& ring, std::size_t i) {
    return ring.first + static_cast<int>(i % ring.angles.size());
  };
  const auto angle = [](const Ring& ring, std::size_t i) {
    return ring.angles[i % ring.angles.size()] + (i < ring.angles.size() ? 0 : 2 * pi);
  };
  // Goes around both at once; the next edge is the one whose middle comes first.
  std::size_t in = 0, out = 0;
  const std::size_t inner_edges = inner.angles.size() == 1 ? 0 : inner.angles.size();
  while (in < inner_edges || out < outer.angles.size()) {
    const bool outwards = in == inner_edges || (out < outer.angles.size() &&
                                                angle(outer, out) + angle(outer, out + 1) <=
                                                    angle(inner, in) + angle(inner, in + 1) + 1e-9);
    if (outwards) {
      triangles_.push_back({node(inner, in), node(outer, out), node(outer, out + 1)});
      ++out;
    } else {
      triangles_.push_back({node(inner, in), node(outer, out), node(inner, in + 1)});
      ++in;
    }
  }
}

void TankModel::order_nodes() {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& corners : triangles_) {
    for (const int a : corners) {
      for (const int b : corners) entries.emplace_back(a, b, 1);
    }
  }
  Eigen::SparseMatrix<double> pattern(nodes_.cols(), nodes_.cols());
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  const Eigen::VectorXi place = order.inverse().eval().indices();
  const Eigen::Matrix2Xd before = nodes_;
  nodes_(Eigen::all, place) = before;
  for (auto& corners : triangles_) {
    for (int& node : corners) node = place[node];
  }
  for (Segment& segment : segments_) {
    for (int& node : segment.ends) node = place[node];
  }
}

TankModel::TankModel(int refinement) {
  const std::vector<Ring> rings = TankModel::rings(refinement);
  nodes_.resize(2, rings.back().first + 1);
  for (const Ring& ring : rings) {
    for (std::size_t i = 0; i < ring.angles.size(); ++i) {
      nodes_.col(ring.first + static_cast<int>(i)) =
          radius * ring.radius *
          Eigen::Vector2d(std::cos(ring.angles[i]), std::sin(ring.angles[i]));
    }
  }
  for (std::size_t r = 1; r < rings.size(); ++r) add_triangles(rings[r], rings[r - 1]);
  const int border = static_cast<int>(rings.front().angles.size());
  const int each = border / electrodes;  // segments of an electrode and a gap
  for (int e = 0; e < electrodes; ++e) {
    for (int s = each * e; s < each * e + each / 2; ++s) {
      const std::array ends = {s, (s + 1) % border};
      segments_.push_back({e, ends, (nodes_.col(ends[1]) - nodes_.col(ends[0])).norm()});
    }
  }
  order_nodes();
  areas_.resize(std::ssize(triangles_));
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    Eigen::Matrix3d corners;
    for (int c = 0; c < 3; ++c) {
      corners.row(c) << 1, nodes_.col(triangles_[t][static_cast<std::size_t>(c)]).transpose();
    }
    areas_[static_cast<Eigen::Index>(t)] = corners.determinant() / 2;
    gradients_.emplace_back(corners.inverse().bottomRows<2>());
  }
}

TankModel::Solution TankModel::solve(const Eigen::VectorXd& conductivity,
                                     const Eigen::VectorXd& contact_impedance) const {
  std::vector<Eigen::Triplet<double>> entries;  // of the lower triangle
  entries.reserve(6 * triangles_.size() + 3 * segments_.size());
  const auto add = [&](const auto& nodes, const auto& block) {
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        if (nodes[a] < nodes[b]) continue;
        entries.emplace_back(nodes[a], nodes[b],
                             block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
      }
    }
  };
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto at = static_cast<Eigen::Index>(t);
    const Eigen::Matrix3d stiffness =
        conductivity[at] * areas_[at] * gradients_[t].transpose() * gradients_[t];
    add(triangles_[t], stiffness);
  }
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(nodes_.cols(), electrodes);
  Eigen::VectorXd admittance = Eigen::VectorXd::Zero(electrodes);
  for (const Segment& segment : segments_) {
    const double length = segment.length / contact_impedance[segment.electrode];
    add(segment.ends, mass_of_segment(length));
    for (const int end : segment.ends) coupling(end, segment.electrode) -= length / 2;
    admittance[segment.electrode] += length;
  }
  Eigen::SparseMatrix<double> stiffness(nodes_.cols(), nodes_.cols());
  stiffness.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
      factor(stiffness);
  const Eigen::MatrixXd to_electrodes = solved(factor.matrixL().nestedExpression(), coupling);
  Eigen::MatrixXd conductance = -coupling.transpose() * to_electrodes;
  conductance.diagonal() += admittance;
  const double trace = conductance.trace();
  conductance.array() += trace / (electrodes * electrodes);  // makes the constant regular
  Solution out;
  out.resistance = conductance.llt().solve(Eigen::MatrixXd::Identity(electrodes, electrodes));
  out.resistance.array() -= 1 / trace;
  out.resistance = (out.resistance + out.resistance.transpose()).eval() / 2;
  out.potentials = -to_electrodes * out.resistance;
  return out;
}

Eigen::VectorXd TankModel::packed(const Eigen::MatrixXd& resistance) {
  Eigen::VectorXd out(pairs);
  Eigen::Index at = 0;
  for (int a = 0; a < electrodes; ++a) {
    for (int b = a; b < electrodes; ++b) out[at++] = resistance(a, b);
  }
  return out;
}

Eigen::VectorXf TankModel::sensitivity(const Solution& solution, std::size_t triangle) const {
  const Eigen::Matrix<double, 3, electrodes> corners =
      solution.potentials(triangles_[triangle], Eigen::all);
  const Eigen::Matrix<float, electrodes, 2> field =
      (gradients_[triangle] * corners).transpose().cast<float>();
  const auto area = static_cast<float>(areas_[static_cast<Eigen::Index>(triangle)]);
  Eigen::VectorXf out(pairs);
  Eigen::Index at = 0;
  for (int a = 0; a < electrodes; ++a) {
    const Eigen::Index count = electrodes - a;
    out.segment(at, count) = -area * field(a, 0) * field.col(0).tail(count) -
                             area * field(a, 1) * field.col(1).tail(count);
    at += count;
  }
  return out;
}

Eigen::VectorXd TankModel::node_areas() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(nodes_.cols());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (const int node : triangles_[t]) out[node] += areas_[static_cast<Eigen::Index>(t)] / 3;
  }
  return out;
}

Eigen::MatrixXd TankModel::impedance_sensitivity(const Solution& solution,
                                                 const Eigen::VectorXd& contact_impedance) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(pairs, electrodes);
  for (const auto& [e, ends, length] : segments_) {
    const Eigen::Matrix<double, 2, electrodes> drop =
        solution.potentials(ends, Eigen::all).rowwise() - solution.resistance.row(e);
    out.col(e) += packed(drop.transpose() * mass_of_segment(length / contact_impedance[e]) * drop);
  }
  return out;
}

Eigen::MatrixXd TankModel::image(const Eigen::VectorXd& nodal, int size) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size, size);
  const double pixel = 2 * radius / size;
  const auto centre = [&](int i) { return (i + 0.5) * pixel - radius; };
  const auto range = [&](double low, double high) {
    return std::pair(std::max(0, static_cast<int>((low + radius) / pixel - 0.5)),
                     std::min(size - 1, static_cast<int>((high + radius) / pixel + 0.5)));
  };
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& corners = triangles_[t];
    const Eigen::Matrix<double, 2, 3> at = nodes_(Eigen::all, corners);
    const auto [left, right] = range(at.row(0).minCoeff(), at.row(0).maxCoeff());
    const auto [bottom, top] = range(at.row(1).minCoeff(), at.row(1).maxCoeff());
    for (int y = bottom; y <= top; ++y) {
      for (int x = left; x <= right; ++x) {
        Eigen::Vector3d weights = gradients_[t].transpose() *
                                  (Eigen::Vector2d(centre(x), centre(y)) - at.rowwise().mean());
        weights.array() += 1.0 / 3;
        if (weights.minCoeff() < -1e-9) continue;
        out(size - 1 - y, x) = weights.dot(nodal(corners));
      }
    }
  }
  return out;
}

}  // namespace ertbench
