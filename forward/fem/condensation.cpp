#include "forward/fem/condensation.h"

#include <Eigen/LU>
#include <algorithm>

namespace ertbench {
namespace {

/// One number for each of `lanes` sheets.
using Packet = double __attribute__((vector_size(sizeof(double) * Condensation::lanes)));

/// Dense symmetric frontal matrix: first the nodes to eliminate, then those to keep. Row-major,
/// lower triangle.
struct Front {
  int eliminated = 0;
  std::vector<int> nodes;

  // A leaf assembles its pixels: the pixel, and its four corners as positions in `nodes`.
  struct Pixel {
    int index;
    std::array<int, 4> corners;  ///< around the pixel
  };
  std::vector<Pixel> pixels;

  // Any other front adds the Schur complements of its two children.
  std::array<int, 2> children = {-1, -1};
  std::array<std::vector<int>, 2> positions;  ///< in `nodes`, of the nodes that each child left

  std::size_t schur_offset = 0;  ///< in packets, on the stack of Schur complements

  int size() const { return static_cast<int>(nodes.size()); }
  int kept() const { return size() - eliminated; }
};

struct Block {
  int row, column, rows, columns;  ///< in pixels
};

std::size_t square(int size) {
  return static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
}

/// F(i, k) -= sum_q w(i, q) F(k, first + q) over the trailing lower triangle, for `Rows` rows i at
/// a time; w = F(i, pivot) / F(pivot, pivot).
template <int Rows, int Pivots>
inline void update_rows(Packet* front, int size, int first, int row, const Packet* inverse) {
  Packet w[Rows][Pivots];
  for (int r = 0; r < Rows; ++r) {
    for (int q = 0; q < Pivots; ++q) w[r][q] = front[(row + r) * size + first + q] * inverse[q];
  }
  for (int k = first + Pivots; k < row + Rows; ++k) {
    const Packet* source = front + k * size + first;
    for (int r = 0; r < Rows; ++r) {
      Packet value = front[(row + r) * size + k];
      for (int q = 0; q < Pivots; ++q) value -= w[r][q] * source[q];
      front[(row + r) * size + k] = value;
    }
  }
}

template <int Pivots>
void eliminate_panel(Packet* front, int size, int first) {
  Packet inverse[Pivots];
  for (int q = 0; q < Pivots; ++q) {
    const int pivot = first + q;
    inverse[q] = 1.0 / front[pivot * size + pivot];
    for (int i = pivot + 1; i < size; ++i) {
      const Packet w = front[i * size + pivot] * inverse[q];
      for (int p = q + 1; p < Pivots && first + p <= i; ++p) {
        front[i * size + first + p] -= w * front[(first + p) * size + pivot];
      }
    }
  }
  int row = first + Pivots;
  for (; row + 4 <= size; row += 4) update_rows<4, Pivots>(front, size, first, row, inverse);
  for (; row < size; ++row) update_rows<1, Pivots>(front, size, first, row, inverse);
}

/// Eliminates the first `count` unknowns of a symmetric positive definite front.
void eliminate(Packet* front, int size, int count) {
  int first = 0;
  for (; first + 4 <= count; first += 4) eliminate_panel<4>(front, size, first);
  switch (count - first) {
    case 3:
      eliminate_panel<3>(front, size, first);
      break;
    case 2:
      eliminate_panel<2>(front, size, first);
      break;
    case 1:
      eliminate_panel<1>(front, size, first);
      break;
    default:
      break;
  }
}

/// Inverse in place of a symmetric positive definite matrix, all of it stored (Gauss-Jordan).
void invert(Packet* matrix, int size) {
  for (int p = 0; p < size; ++p) {
    const Packet inverse = 1.0 / matrix[p * size + p];
    for (int i = 0; i < size; ++i) {
      if (i == p) continue;
      const Packet w = matrix[i * size + p] * inverse;
      for (int k = 0; k < size; ++k) {
        if (k != p) matrix[i * size + k] -= w * matrix[p * size + k];
      }
      matrix[i * size + p] = -w;
    }
    for (int k = 0; k < size; ++k) matrix[p * size + k] *= inverse;
    matrix[p * size + p] = inverse;
  }
}

/// Conductivity ratios of the pixels around a node, 0 outside the sheet: lower left, lower right,
/// upper left, upper right.
std::array<double, 4> pixels_around(const double* ratio, int columns, int rows, int row,
                                    int column) {
  const auto at = [&](int r, int c) {
    return r < 0 || c < 0 || r >= rows || c >= columns ? 0.0 : ratio[c + columns * r];
  };
  return {at(row - 1, column - 1), at(row - 1, column), at(row, column - 1), at(row, column)};
}

}  // namespace

struct Condensation::Plan {
  int columns = 0;
  int rows = 0;
  std::vector<char> is_electrode;
  std::vector<int> electrodes;
  std::vector<Front> fronts;  ///< children before parents, the whole sheet last
  std::size_t stack_size = 0;
  int largest_front = 0;

  int build(const Block& block, std::size_t stack_offset);
  bool stays(int node, const Block& block) const;
};

/// True if a node of the block is needed outside of it.
bool Condensation::Plan::stays(int node, const Block& block) const {
  if (is_electrode[static_cast<std::size_t>(node)]) return true;
  const int row = node / (columns + 1);
  const int column = node % (columns + 1);
  return (row == block.row && row > 0) || (row == block.row + block.rows && row < rows) ||
         (column == block.column && column > 0) ||
         (column == block.column + block.columns && column < columns);
}

int Condensation::Plan::build(const Block& block, std::size_t stack_offset) {
  Front front;
  std::vector<int> nodes;
  const bool leaf = std::max(block.rows, block.columns) <= 3;
  if (leaf) {
    for (int row = block.row; row <= block.row + block.rows; ++row) {
      for (int column = block.column; column <= block.column + block.columns; ++column) {
        nodes.push_back(column + (columns + 1) * row);
      }
    }
  } else {
    Block first = block;
    Block second = block;
    if (block.rows >= block.columns) {
      first.rows = block.rows / 2;
      second.rows = block.rows - first.rows;
      second.row += first.rows;
    } else {
      first.columns = block.columns / 2;
      second.columns = block.columns - first.columns;
      second.column += first.columns;
    }
    front.children[0] = build(first, stack_offset);
    const std::size_t first_size =
        square(fronts[static_cast<std::size_t>(front.children[0])].kept());
    front.children[1] = build(second, stack_offset + first_size);
    for (const int child : front.children) {
      const Front& below = fronts[static_cast<std::size_t>(child)];
      nodes.insert(nodes.end(), below.nodes.begin() + below.eliminated, below.nodes.end());
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }

  const auto kept = std::stable_partition(nodes.begin(), nodes.end(),
                                          [&](int node) { return !stays(node, block); });
  front.eliminated = static_cast<int>(kept - nodes.begin());
  const bool whole = block.rows == rows && block.columns == columns;
  if (whole) std::copy(electrodes.begin(), electrodes.end(), kept);
  front.nodes = nodes;
  const auto position = [&](int node) {
    return static_cast<int>(std::find(nodes.begin(), nodes.end(), node) - nodes.begin());
  };
  if (leaf) {
    for (int row = block.row; row < block.row + block.rows; ++row) {
      for (int column = block.column; column < block.column + block.columns; ++column) {
        const int corner = column + (columns + 1) * row;
        front.pixels.push_back({column + columns * row,
                                {position(corner), position(corner + 1),
                                 position(corner + columns + 2), position(corner + columns + 1)}});
      }
    }
  } else {
    for (std::size_t c = 0; c < 2; ++c) {
      const Front& below = fronts[static_cast<std::size_t>(front.children[c])];
      for (int i = below.eliminated; i < below.size(); ++i) {
        front.positions[c].push_back(position(below.nodes[static_cast<std::size_t>(i)]));
      }
    }
  }
  front.schur_offset = stack_offset;
  stack_size = std::max(stack_size, stack_offset + square(front.kept()));
  largest_front = std::max(largest_front, front.size());
  fronts.push_back(std::move(front));
  return static_cast<int>(fronts.size()) - 1;
}

struct Condensation::Workspace::Buffers {
  std::vector<Packet> ratio;
  std::vector<Packet> front;
  std::vector<Packet> stack;
};

Condensation::Condensation(int columns, int rows, const std::vector<int>& electrodes)
    : plan_(std::make_unique<Plan>()) {
  plan_->columns = columns;
  plan_->rows = rows;
  plan_->electrodes = electrodes;
  plan_->is_electrode.assign(static_cast<std::size_t>((columns + 1) * (rows + 1)), 0);
  for (const int node : electrodes) plan_->is_electrode[static_cast<std::size_t>(node)] = 1;
  plan_->build({0, 0, rows, columns}, 0);
}
Condensation::~Condensation() = default;
Condensation::Condensation(Condensation&&) noexcept = default;

Condensation::Workspace::Workspace(const Condensation& condensation)
    : buffers_(std::make_unique<Buffers>()) {
  const Plan& plan = *condensation.plan_;
  buffers_->ratio.resize(static_cast<std::size_t>(plan.columns * plan.rows));
  buffers_->front.resize(square(plan.largest_front));
  buffers_->stack.resize(plan.stack_size);
}
Condensation::Workspace::~Workspace() = default;

void Condensation::solve(const std::array<const double*, lanes>& ratio,
                         std::array<Eigen::MatrixXd, lanes>& impedance,
                         Workspace& workspace) const {
  auto& [pixels, matrix, stack] = *workspace.buffers_;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const double* source = ratio[lane] ? ratio[lane] : ratio[0];
    for (std::size_t p = 0; p < pixels.size(); ++p) pixels[p][lane] = source[p];
  }

  Packet* front = matrix.data();
  for (const Front& plan : plan_->fronts) {
    const int size = plan.size();
    std::fill_n(front, square(size), Packet{});
    const auto add = [&](int i, int k, const Packet& value) {
      front[std::max(i, k) * size + std::min(i, k)] += value;
    };
    for (const Front::Pixel& pixel : plan.pixels) {
      // Half a pixel's conductivity on each of its four edges.
      const Packet half = 0.5 * pixels[static_cast<std::size_t>(pixel.index)];
      for (std::size_t c = 0; c < 4; ++c) {
        add(pixel.corners[c], pixel.corners[c], half + half);
        add(pixel.corners[c], pixel.corners[(c + 1) % 4], -half);
      }
    }
    for (std::size_t c = 0; c < 2; ++c) {
      if (plan.children[c] < 0) continue;
      const Packet* schur =
          stack.data() + plan_->fronts[static_cast<std::size_t>(plan.children[c])].schur_offset;
      const std::vector<int>& positions = plan.positions[c];
      for (std::size_t i = 0; i < positions.size(); ++i) {
        for (std::size_t k = 0; k <= i; ++k) add(positions[i], positions[k], *schur++);
      }
    }
    eliminate(front, size, plan.eliminated);
    Packet* schur = stack.data() + plan.schur_offset;
    for (int i = plan.eliminated; i < size; ++i) {
      schur = std::copy(front + i * size + plan.eliminated, front + i * size + i + 1, schur);
    }
  }

  // The network between the electrodes, the last one grounded.
  const int electrodes = static_cast<int>(plan_->electrodes.size());
  const int free = electrodes - 1;
  const Packet* network = stack.data() + plan_->fronts.back().schur_offset;
  for (int i = 0; i < free; ++i) {
    for (int k = 0; k <= i; ++k) {
      front[i * free + k] = front[k * free + i] = *network++;
    }
  }
  invert(front, free);
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    if (!ratio[lane]) continue;
    impedance[lane].setZero(electrodes, electrodes);
    for (int i = 0; i < free; ++i) {
      for (int k = 0; k < free; ++k) impedance[lane](i, k) = front[i * free + k][lane];
    }
  }
}

ContactUpdate::ContactUpdate(int columns, int rows, std::vector<int> electrodes,
                             std::vector<ElectrodePair> pairs)
    : columns_(columns),
      rows_(rows),
      electrodes_(std::move(electrodes)),
      pairs_(std::move(pairs)),
      is_electrode_(static_cast<std::size_t>((columns + 1) * (rows + 1)), 0),
      green_(columns, rows) {
  const int side = columns + 1;
  const int nodes = side * (rows + 1);
  const auto count = static_cast<Eigen::Index>(electrodes_.size());
  RowMajorMatrix potentials(nodes, count);  // of a unit current into each electrode
  for (Eigen::Index e = 0; e < count; ++e) {
    const int source = electrodes_[static_cast<std::size_t>(e)];
    is_electrode_[static_cast<std::size_t>(source)] = 1;
    for (int node = 0; node < nodes; ++node) {
      potentials(node, e) = green_(node / side, node % side, source / side, source % side);
    }
  }
  fields_.resize(nodes, static_cast<Eigen::Index>(pairs_.size()));
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    fields_.col(static_cast<Eigen::Index>(k)) =
        potentials.col(pairs_[k].second) - potentials.col(pairs_[k].first);
  }
}

std::vector<int> ContactUpdate::active_nodes(const double* ratio) const {
  std::vector<int> active;
  const int side = columns_ + 1;
  for (int row = 0; row <= rows_; ++row) {
    const double* below = ratio + columns_ * std::max(row - 1, 0);
    const double* above = ratio + columns_ * std::min(row, rows_ - 1);
    for (int column = 0; column < side; ++column) {
      const int left = std::max(column - 1, 0);
      const int right = std::min(column, columns_ - 1);
      const double first = below[left];
      const bool uniform = below[right] == first && above[left] == first && above[right] == first;
      const int node = column + side * row;
      if (!uniform || (first != 1 && is_electrode_[static_cast<std::size_t>(node)])) {
        active.push_back(node);
      }
    }
  }
  return active;
}

Eigen::Array4d ContactUpdate::edges(const double* ratio, int node) const {
  const int side = columns_ + 1;
  const auto [lower_left, lower_right, upper_left, upper_right] =
      pixels_around(ratio, columns_, rows_, node / side, node % side);
  return 0.5 * Eigen::Array4d(lower_left + upper_left, lower_right + upper_right,
                              lower_left + lower_right, upper_left + upper_right);
}

Eigen::MatrixXd ContactUpdate::impedance_change(const double* ratio,
                                                const std::vector<int>& active) const {
  const int side = columns_ + 1;
  const auto count = static_cast<Eigen::Index>(active.size());
  const auto drives = static_cast<Eigen::Index>(pairs_.size());

  // The Green's function from every active node to the active nodes and their neighbours, one row
  // a receiving node.
  const std::array<int, 4> step = {-1, 1, -side, side};
  std::vector<int> row_of(is_electrode_.size(), -1);
  std::vector<int> receivers;
  const auto receive = [&](int node) {
    if (row_of[static_cast<std::size_t>(node)] >= 0) return;
    row_of[static_cast<std::size_t>(node)] = static_cast<int>(receivers.size());
    receivers.push_back(node);
  };
  std::vector<Eigen::Array4d> conductances(active.size());
  for (std::size_t i = 0; i < active.size(); ++i) {
    conductances[i] = edges(ratio, active[i]);
    receive(active[i]);
    for (std::size_t e = 0; e < 4; ++e) {
      if (conductances[i][static_cast<Eigen::Index>(e)] > 0) receive(active[i] + step[e]);
    }
  }
  RowMajorMatrix green(static_cast<Eigen::Index>(receivers.size()), count);
  for (std::size_t r = 0; r < receivers.size(); ++r) {
    const int row = receivers[r] / side;
    const int column = receivers[r] % side;
    double* out = green.row(static_cast<Eigen::Index>(r)).data();
    for (std::size_t j = 0; j < active.size(); ++j) {
      out[j] = green_(row, column, active[j] / side, active[j] % side);
    }
  }

  // Rows of K at the active nodes, applied to G and to u0.
  RowMajorMatrix system(count, count);
  RowMajorMatrix currents(count, drives);
  RowMajorMatrix fields(count, drives);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int node = active[static_cast<std::size_t>(i)];
    const Eigen::Array4d& conductance = conductances[static_cast<std::size_t>(i)];
    fields.row(i) = fields_.row(node);
    system.row(i) = conductance.sum() * green.row(row_of[static_cast<std::size_t>(node)]);
    currents.row(i) = -conductance.sum() * fields.row(i);
    for (Eigen::Index e = 0; e < 4; ++e) {
      if (conductance[e] == 0) continue;
      const int neighbour = node + step[static_cast<std::size_t>(e)];
      system.row(i) -= conductance[e] * green.row(row_of[static_cast<std::size_t>(neighbour)]);
      currents.row(i) += conductance[e] * fields_.row(neighbour);
    }
  }
  const auto add_current = [&](int electrode, Eigen::Index pair, double current) {
    const int node = electrodes_[static_cast<std::size_t>(electrode)];
    const auto found = std::lower_bound(active.begin(), active.end(), node);
    if (found != active.end() && *found == node) currents(found - active.begin(), pair) += current;
  };
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    add_current(pairs_[k].first, static_cast<Eigen::Index>(k), -1);
    add_current(pairs_[k].second, static_cast<Eigen::Index>(k), 1);
  }
  return fields.transpose() * system.partialPivLu().solve(currents);
}

}  // namespace ertbench
