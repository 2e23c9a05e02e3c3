#include "bench/ktc2023/simulated_tanks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr double ratios[] = {1, 0.02, 15};  // conductivity of a class to water's

}  // namespace

bool SimulatedCylinders::Section::holds(const Eigen::Vector2d& point) const {
  const auto corner = [&](std::size_t i) -> Eigen::Vector2d {
    const double angle = angles[i % angles.size()];
    return centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const Eigen::Vector2d side = corner(i + 1) - corner(i);
    const Eigen::Vector2d from = point - corner(i);
    if (side.x() * from.y() - side.y() * from.x() < 0) return false;
  }
  return true;
}

SimulatedCylinders::Section SimulatedCylinders::random_section(RandomStream& random) {
  Section out{{}, random.uniform(0.013, 0.028), random.integer(1, 2), {}};
  const double distance = std::sqrt(random.uniform()) * (0.108 - out.radius);
  const double direction = random.uniform(0, 2 * std::numbers::pi);
  out.centre = distance * Eigen::Vector2d(std::cos(direction), std::sin(direction));
  const bool round = random.uniform() < 0.4;
  const int sides = round ? 32 : random.integer(3, 6);
  const double turn = random.uniform(0, 2 * std::numbers::pi);
  for (int i = 0; i < sides; ++i) {
    const double moved = round ? 0 : random.uniform(-0.2, 0.2);
    out.angles.push_back(turn + (i + moved) * 2 * std::numbers::pi / sides);
  }
  return out;
}

SimulatedCylinders::SimulatedCylinders(RandomStream& random, std::size_t count) {
  constexpr double gap = 0.006;
  while (sections_.size() < count) {
    const Section next = random_section(random);
    const bool free = std::all_of(sections_.begin(), sections_.end(), [&](const Section& other) {
      return (other.centre - next.centre).norm() > other.radius + next.radius + gap;
    });
    if (free) sections_.push_back(next);
  }
}

int SimulatedCylinders::kind_at(const Eigen::Vector2d& point) const {
  for (const Section& section : sections_) {
    if (section.holds(point)) return section.kind;
  }
  return 0;
}

Eigen::VectorXd SimulatedCylinders::conductivity(const TankModel& tank, double water) const {
  Eigen::VectorXd out(std::ssize(tank.triangles()));
  for (std::size_t t = 0; t < tank.triangles().size(); ++t) {
    const Eigen::Vector2d at = tank.nodes()(Eigen::all, tank.triangles()[t]).rowwise().mean();
    out[static_cast<Eigen::Index>(t)] = water * ratios[kind_at(at)];
  }
  return out;
}

std::vector<KtcTarget> simulate_ktc_targets(const KtcReference& reference,
                                            const std::filesystem::path& reference_file,
                                            const KtcCalibration& calibration, int count,
                                            std::uint64_t seed) {
  if (!reference.voltages.allFinite()) {
    throw InputError(printable_path(reference_file.string()) +
                     ": lacks channels, so that no whole target can be simulated; leave "
                     "\"simulated\" out");
  }
  const TankModel tank(2);
  const Eigen::MatrixXd channels =
      channel_operator(reference.patterns, calibration.gain, calibration.common_mode);
  const Eigen::VectorXd water =
      Eigen::VectorXd::Constant(std::ssize(tank.triangles()), calibration.conductivity);
  const Eigen::MatrixXd empty = tank.solve(water, calibration.contact_impedance).resistance;
  std::vector<KtcTarget> out;
  for (int i = 0; i < count; ++i) {
    RandomStream random(seed, key_of("ktc2023"), static_cast<std::uint64_t>(i), Purpose::scene);
    const SimulatedCylinders cylinders(random, static_cast<std::size_t>(1 + i % 5));
    const Eigen::VectorXd conductivity = cylinders.conductivity(tank, calibration.conductivity);
    const Eigen::VectorXd change =
        channels * TankModel::packed(
                       tank.solve(conductivity, calibration.contact_impedance).resistance - empty);
    KtcTarget& target = out.emplace_back();
    target.name = "simulated " + std::to_string(i + 1);
    target.any_level = true;
    target.reference = reference_file;
    target.patterns = reference.patterns;
    target.voltages = reference.voltages;
    for (Eigen::Index c = 0; c < change.size(); ++c) {
      target.voltages[c] += reference.patterns.amplitude(c) *
                            (change[c] * (1 + 0.01 * random.normal()) + 0.001 * random.normal());
    }
    ClassMap& truth = target.truth.emplace(256, 256);
    for (int row = 0; row < 256; ++row) {
      for (int column = 0; column < 256; ++column) {
        truth(row, column) = cylinders.kind_at(TankModel::radius / 128 *
                                               Eigen::Vector2d(column - 127.5, 127.5 - row));
      }
    }
  }
  return out;
}

}  // namespace ertbench
