#include "solvers/contacts/contact_image.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/random.h"
#include "forward/sheet/rasterise.h"
#include "solvers/channel_mask.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index samples = 48;  ///< half of them mirrored in the maximum
constexpr Index most_parameters = 16 * EllipticContact::parameters;
/// Bound on deviations from the maximum in size, stretch and ratio, beyond which Laplace's
/// approximation fails: the posterior of a weak contact is no Gaussian.
constexpr double farthest_log = 1.5;

/// Noise assumed for a set without any, relative to the reference voltages: 80 dB.
constexpr double least_noise = 1e-4;

/// True for measured frames, whose voltages without noise are unknown.
bool is_measured(const DatasetFile& set) {
  return nlohmann::json::parse(set.recipe(), nullptr, false).contains("file");
}

}  // namespace

ContactImage::ContactImage(const Sensor& sensor)
    : pixels_(sensor.image()), background_(sensor.background), samples_(most_parameters, samples) {
  RandomStream random(1, key_of("posterior mean"), 0, Purpose::scene);
  for (Index s = 0; s + 1 < samples; s += 2) {
    for (Index i = 0; i < most_parameters; ++i) samples_(i, s) = random.normal();
    samples_.col(s + 1) = -samples_.col(s);
  }
}

void ContactImage::most_likely(std::span<const EllipticContact> contacts,
                               Eigen::Ref<Eigen::RowVectorXd> image) const {
  VectorXd ratio(pixels_.count());
  rasterise(scene_of(contacts), pixels_, Rasterisation::area, ratio);
  image = background_ * (ratio.array() - 1).matrix().transpose();
}

void ContactImage::add_sample(std::span<const EllipticContact> contacts, double weight,
                              Eigen::Ref<Eigen::RowVectorXd> image) const {
  const Eigen::Vector2d pixel = pixels_.pixel();
  const double side = std::sqrt(pixel.prod());
  const Eigen::Vector2d low = pixels_.corner(0);
  for (const EllipticContact& contact : contacts) {
    const Eigen::Vector2d axes = contact.half_axes();
    const Eigen::Matrix2d to_unit =
        axes.cwiseInverse().asDiagonal() * Eigen::Rotation2Dd(-contact.angle()).toRotationMatrix();
    const Eigen::Matrix2d metric = to_unit.transpose() * to_unit;
    const double change = (contact.ratio() - 1) * weight;
    const double cos = std::cos(contact.angle());
    const double sin = std::sin(contact.angle());
    const Eigen::Vector2d reach(std::hypot(axes.x() * cos, axes.y() * sin) + side,
                                std::hypot(axes.x() * sin, axes.y() * cos) + side);
    const Eigen::Array2d from = ((contact.centre - reach - low).array() / pixel.array()).floor();
    const Eigen::Array2d to = ((contact.centre + reach - low).array() / pixel.array()).ceil();
    const int first_column = std::max(0, static_cast<int>(from.x()));
    const int last_column = std::min(pixels_.columns(), static_cast<int>(to.x()));
    const int first_row = std::max(0, static_cast<int>(from.y()));
    const int last_row = std::min(pixels_.rows(), static_cast<int>(to.y()));
    for (int row = first_row; row < last_row; ++row) {
      const double y = low.y() + (row + 0.5) * pixel.y() - contact.centre.y();
      double* target = &image[static_cast<Index>(row) * pixels_.columns()];
      for (int column = first_column; column < last_column; ++column) {
        const double x = low.x() + (column + 0.5) * pixel.x() - contact.centre.x();
        const double gx = metric(0, 0) * x + metric(0, 1) * y;
        const double gy = metric(0, 1) * x + metric(1, 1) * y;
        const double square = gx * x + gy * y;
        // Distance to the border: (1 - r^2) / |grad r^2|.
        const double slope = 2 * std::sqrt(gx * gx + gy * gy) + 1e-12;
        const double covered = std::clamp(0.5 + (1 - square) / (slope * side), 0.0, 1.0);
        target[column] += change * covered;
      }
    }
  }
}

void ContactImage::add_mean(const ContactFit::Result& result, double weight,
                            Eigen::Ref<Eigen::RowVectorXd> image) const {
  if (result.contacts.empty()) return;
  const Index size = result.precision.rows();
  const Eigen::LLT<Eigen::MatrixXd> factor(result.precision);
  Eigen::MatrixXd steps = samples_.topRows(size);
  factor.matrixU().solveInPlace(steps);
  std::vector<EllipticContact> contacts(result.contacts.size());
  for (Index s = 0; s < samples; ++s) {
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      EllipticContact::Vector step = steps.col(s).segment<EllipticContact::parameters>(
          EllipticContact::parameters * static_cast<Index>(k));
      if (result.discs) step.segment<2>(3).setZero();
      step.tail<4>() = step.tail<4>().cwiseMax(-farthest_log).cwiseMin(farthest_log);
      contacts[k] = EllipticContact::from(result.contacts[k].vector() + step);
      // A contact does not change its sign.
      if (contacts[k].log_ratio * result.contacts[k].log_ratio < 0) contacts[k].log_ratio = 0;
    }
    add_sample(contacts, weight / static_cast<double>(samples), image);
  }
}

void ContactImage::posterior_mean(const ContactFit::Found& found,
                                  Eigen::Ref<Eigen::RowVectorXd> image) const {
  image.setZero();
  double share = 0;
  if (found.has_other) {
    share = 1 / (1 + std::exp(found.best.log_evidence - found.other.log_evidence));
    add_mean(found.other, share, image);
  }
  add_mean(found.best, 1 - share, image);
  image *= background_;
}

std::optional<double> noise_of_channel(const DatasetFile& set, ElectrodeSet masked) {
  const Frames voltages = set.voltages(0, std::min(set.size(), judged_frames));
  double sum = 0;
  double count = 0;
  const auto pairs = reciprocal_pairs(set.sensor());
  const auto electrodes = electrodes_of_pairs(set.sensor());
  const bool single = std::ssize(pairs) == set.sensor().channels();
  // Without reciprocal channels the noise is that of the simulated set.
  const Frames clean =
      single ? set.clean_voltages(0, std::min(set.size(), judged_frames)) : Frames();
  for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
    if (single) {
      sum += (voltages.row(f) - clean.row(f)).squaredNorm();
      count += static_cast<double>(pairs.size());
      continue;
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if ((electrodes[p] & masked) != 0 || pairs[p][0] == pairs[p][1]) continue;
      sum += std::pow(voltages(f, pairs[p][0]) - voltages(f, pairs[p][1]), 2) / 2;
      count += 1;
    }
  }
  if (single && is_measured(set)) return std::nullopt;
  const double least = least_noise * set.reference_voltages().norm() /
                       std::sqrt(static_cast<double>(set.reference_voltages().size()));
  return std::max(least, std::sqrt(sum / std::max(1.0, count)));
}

std::vector<Eigen::Index> frames_like(const DatasetFile& set, std::uint64_t count,
                                      const std::optional<std::pair<double, double>>& ratio) {
  constexpr std::size_t enough = 20;
  std::vector<Eigen::Index> like;
  if (ratio) {
    const std::vector<Scene> scenes = set.scenes(0, count);
    for (std::size_t f = 0; f < scenes.size(); ++f) {
      const auto& contacts = scenes[f].contacts;
      const bool all = std::all_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
        return contact.conductivity_ratio >= ratio->first &&
               contact.conductivity_ratio <= ratio->second;
      });
      if (all) like.push_back(static_cast<Eigen::Index>(f));
    }
  }
  if (like.size() >= enough) return like;
  like.resize(count);
  std::iota(like.begin(), like.end(), Eigen::Index{0});
  return like;
}

}  // namespace ertbench
