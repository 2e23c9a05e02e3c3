#include "bench/ktc2023/tank_model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

constexpr int border_nodes = 256;

Eigen::Matrix2d mass_of_segment(double length) {
  return (Eigen::Matrix2d() << length / 3, length / 6, length / 6, length / 3).finished();
}

}  // namespace

std::vector<TankModel::Ring> TankModel::rings() {
  // Four rings resolve the ends of the electrodes; inside, triangles grow as the resolution falls.
  std::vector<Ring> out = {{1, 0, 256}, {.978, 0, 256}, {.953, 0, 256}, {.925, 0, 128}};
  const auto to = [&](double least, double step, int count) {
    while (out.back().radius > least) out.push_back({out.back().radius - step, 0, count});
  };
  to(.57, .044, 128);
  out.push_back({out.back().radius - .07, 0, 64});
  to(.34, .078, 64);
  to(.2, .1, 32);
  out.push_back({std::max(out.back().radius - .09, .09), 0, 16});
  out.push_back({0, 0, 1});
  std::reverse(out.begin(), out.end());
  for (std::size_t r = 1; r < out.size(); ++r) out[r].first = out[r - 1].first + out[r - 1].count;
  return out;
}

void TankModel::add_triangles(const Ring& inner, const Ring& outer) {
  const auto in = [&](int i) { return inner.first + i % inner.count; };
  const auto out = [&](int i) { return outer.first + i % outer.count; };
  const int each = inner.count == 1 ? outer.count : outer.count / inner.count;
  for (int i = 0; i < inner.count; ++i) {
    for (int k = 0; k < each; ++k) {
      const int j = i * each + k;
      triangles_.push_back({in(each == 2 && k == 1 ? i + 1 : i), out(j), out(j + 1)});
    }
    if (inner.count == 1) continue;
    const int j = each == 1 ? i + 1 : 2 * i + 1;
    triangles_.push_back({in(i), out(j), in(i + 1)});
  }
}

TankModel::TankModel() : rings_(rings()) {
  using std::numbers::pi;
  nodes_.resize(2, rings_.back().first + rings_.back().count);
  for (const Ring& ring : rings_) {
    for (int i = 0; i < ring.count; ++i) {
      const double angle = 2 * pi * i / ring.count;
      nodes_.col(ring.first + i) =
          radius * ring.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
  }
  for (std::size_t r = 1; r < rings_.size(); ++r) add_triangles(rings_[r - 1], rings_[r]);
  areas_.resize(std::ssize(triangles_));
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    Eigen::Matrix3d corners;
    for (int c = 0; c < 3; ++c) {
      corners.row(c) << 1, nodes_.col(triangles_[t][static_cast<std::size_t>(c)]).transpose();
    }
    areas_[static_cast<Eigen::Index>(t)] = corners.determinant() / 2;
    gradients_.emplace_back(corners.inverse().bottomRows<2>());
  }
  segment_length_ = 2 * radius * std::sin(pi / border_nodes);
  constexpr int each = border_nodes / electrodes / 2;  // segments of an electrode
  const int border = rings_.back().first;
  for (int e = 0; e < electrodes; ++e) {
    const int begin = border_nodes * 15 / 64 - each / 2 + 2 * each * e;  // 84.375 degrees
    for (int s = begin; s < begin + each; ++s) {
      segments_.push_back({e, border + s % border_nodes, border + (s + 1) % border_nodes});
    }
  }
}

TankModel::Solution TankModel::solve(const Eigen::VectorXd& conductivity,
                                     const Eigen::VectorXd& contact_impedance) const {
  // Blocks of the stiffness matrix: of each ring, and from it to the next one outwards.
  std::vector<int> ring_of(static_cast<std::size_t>(nodes_.cols()));
  std::vector<Eigen::MatrixXd> own, next;
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    std::fill_n(ring_of.begin() + rings_[r].first, rings_[r].count, static_cast<int>(r));
    own.emplace_back(Eigen::MatrixXd::Zero(rings_[r].count, rings_[r].count));
    if (r + 1 < rings_.size()) {
      next.emplace_back(Eigen::MatrixXd::Zero(rings_[r].count, rings_[r + 1].count));
    }
  }
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto at = static_cast<Eigen::Index>(t);
    const Eigen::Matrix3d stiffness =
        conductivity[at] * areas_[at] * gradients_[t].transpose() * gradients_[t];
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        const int from = triangles_[t][static_cast<std::size_t>(a)];
        const int to = triangles_[t][static_cast<std::size_t>(b)];
        const auto r = static_cast<std::size_t>(ring_of[static_cast<std::size_t>(from)]);
        const auto q = static_cast<std::size_t>(ring_of[static_cast<std::size_t>(to)]);
        if (q < r) continue;
        (q == r ? own : next)[r](from - rings_[r].first, to - rings_[q].first) += stiffness(a, b);
      }
    }
  }
  const int border = rings_.back().first;
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(border_nodes, electrodes);
  Eigen::VectorXd admittance = Eigen::VectorXd::Zero(electrodes);
  for (const auto& [e, a, b] : segments_) {
    const double length = segment_length_ / contact_impedance[e];
    const std::array<int, 2> ends = {a - border, b - border};
    own.back()(ends, ends) += mass_of_segment(length);
    for (const int end : ends) coupling(end, e) -= length / 2;
    admittance[e] += length;
  }
  std::vector<Eigen::MatrixXd> inwards;  // potentials of a ring from those of the next one
  for (std::size_t r = 0; r < next.size(); ++r) {
    inwards.emplace_back(own[r].llt().solve(next[r]));
    own[r + 1].noalias() -= next[r].transpose() * inwards.back();
  }
  const Eigen::MatrixXd to_border = own.back().llt().solve(coupling);
  Eigen::MatrixXd conductance = -coupling.transpose() * to_border;
  conductance.diagonal() += admittance;
  const double trace = conductance.trace();
  conductance.array() += trace / (electrodes * electrodes);  // makes the constant regular
  Solution out;
  out.resistance = conductance.llt().solve(Eigen::MatrixXd::Identity(electrodes, electrodes));
  out.resistance.array() -= 1 / trace;
  out.resistance = (out.resistance + out.resistance.transpose()).eval() / 2;
  out.potentials.resize(nodes_.cols(), electrodes);
  out.potentials.bottomRows(border_nodes) = -to_border * out.resistance;
  for (std::size_t r = next.size(); r-- > 0;) {
    out.potentials.middleRows(rings_[r].first, rings_[r].count) =
        -inwards[r] * out.potentials.middleRows(rings_[r + 1].first, rings_[r + 1].count);
  }
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

Eigen::MatrixXd TankModel::sensitivity(const Solution& solution) const {
  Eigen::MatrixXd out(pairs, std::ssize(triangles_));
  Eigen::Matrix<double, 3, electrodes> corners;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto at = static_cast<Eigen::Index>(t);
    for (int c = 0; c < 3; ++c) {
      corners.row(c) = solution.potentials.row(triangles_[t][static_cast<std::size_t>(c)]);
    }
    const Eigen::Matrix<double, 2, electrodes> field = gradients_[t] * corners;
    out.col(at) = packed(-areas_[at] * field.transpose() * field);
  }
  return out;
}

Eigen::MatrixXd TankModel::impedance_sensitivity(const Solution& solution,
                                                 const Eigen::VectorXd& contact_impedance) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(pairs, electrodes);
  for (const auto& [e, a, b] : segments_) {
    Eigen::Matrix<double, 2, electrodes> drop;
    drop.row(0) = solution.potentials.row(a) - solution.resistance.row(e);
    drop.row(1) = solution.potentials.row(b) - solution.resistance.row(e);
    out.col(e) +=
        packed(drop.transpose() * mass_of_segment(segment_length_ / contact_impedance[e]) * drop);
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
