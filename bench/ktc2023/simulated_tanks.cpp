#include "bench/ktc2023/simulated_tanks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/process.h"
#include "core/text.h"
#include "forward/sheet/sheet.h"

namespace ertbench {
namespace {

constexpr double ratios[] = {1, 0.02, 15};  // conductivity of a class to water's
// As conductivities, which must be positive.
constexpr double class_values[] = {0.5, 0.01, 1};

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

SimulatedCylinders::Section SimulatedCylinders::random_section(RandomStream& random,
                                                               double largest) {
  Section out{{}, random.uniform(0.013, largest), random.integer(1, 2), {}};
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

SimulatedCylinders::SimulatedCylinders(RandomStream& random, std::size_t count, double largest) {
  constexpr double gap = 0.006;
  constexpr int patience = 1000;
  for (int tries = 1; sections_.size() < count; ++tries) {
    if (tries % patience == 0) sections_.clear();  // they leave no room
    const Section next = random_section(random, largest);
    const bool free = std::ranges::all_of(sections_, [&](const Section& other) {
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

Eigen::RowVectorXd ideal_voltages(const std::vector<ChannelElectrodes>& channels,
                                  const Eigen::MatrixXd& resistance) {
  Eigen::RowVectorXd out(std::ssize(channels));
  Eigen::Index at = 0;
  for (const auto& [drive, measured] : channels) {
    const auto potential = [&, drive = drive](int electrode) {
      return resistance(electrode, drive.second) - resistance(electrode, drive.first);
    };
    out[at++] = potential(measured.first) - potential(measured.second);
  }
  return out;
}

TrainingTanks::Example TrainingTanks::example(const TankModel& tank,
                                              const Eigen::RowVectorXd& reference,
                                              std::uint64_t number) const {
  RandomStream random(seed, key_of("ktc2023 network"), number, Purpose::scene);
  const SimulatedCylinders cylinders(random, 1 + number % 5, 0.045);
  constexpr double spread = 1.5;  // of an impedance's logarithm
  Eigen::VectorXd impedance(TankModel::electrodes);
  for (double& z : impedance) z = sensor.contact_impedance * std::exp(spread * random.normal());
  const Eigen::VectorXd water = Eigen::VectorXd::Ones(std::ssize(tank.triangles()));
  Example out;
  out.change = ideal_voltages(electrodes_of_channels(sensor),
                              tank.solve(cylinders.conductivity(tank, 1), impedance).resistance -
                                  tank.solve(water, impedance).resistance);
  // What the instrument and its model leave, of a channel's change and of the reference's size.
  constexpr double of_change = 0.03;
  constexpr double of_reference = 0.003;
  const double noise =
      of_reference * reference.norm() / std::sqrt(static_cast<double>(reference.size()));
  for (double& v : out.change) v *= 1 + of_change * random.normal();
  for (double& v : out.change) v += noise * random.normal();
  const int grid = sensor.image_grid;
  constexpr int parts = 4;  // of a pixel's side
  out.classes.setZero(Eigen::Index{grid} * grid);
  for (int row = 0; row < parts * grid; ++row) {
    for (int column = 0; column < parts * grid; ++column) {
      const Eigen::Vector2d at = Eigen::Vector2d(column + 0.5, row + 0.5) / (parts * grid);
      const int kind = cylinders.kind_at(TankModel::radius * (2 * at.array() - 1).matrix());
      out.classes[row / parts * grid + column / parts] += class_values[kind] / (parts * parts);
    }
  }
  const PixelGrid pixels = sensor.image();
  for (int p = 0; p < pixels.count(); ++p) {
    if (!pixels.on_sheet(p)) out.classes[p] = sensor.background;
  }
  return out;
}

std::filesystem::path TrainingTanks::file_in(const std::filesystem::path& folder,
                                             int threads) const {
  const TankModel tank;
  const Eigen::RowVectorXd reference = ideal_voltages(
      electrodes_of_channels(sensor),
      tank.solve(Eigen::VectorXd::Ones(std::ssize(tank.triangles())),
                 Eigen::VectorXd::Constant(TankModel::electrodes, sensor.contact_impedance))
          .resistance);
  const Example first = example(tank, reference, 0);
  // The name tells what is inside, so that tanks of another program are not taken for these.
  std::string content = to_json(sensor).dump() + std::to_string(count) + " " + std::to_string(seed);
  for (const auto* numbers : {&reference, &first.change, &first.classes}) {
    for (const double v : *numbers) content += " " + std::to_string(v);
  }
  const std::filesystem::path file = folder / ("tanks-" + hash_of(content).substr(0, 16) + ".h5");
  if (std::filesystem::exists(file)) return file;
  RowMajorMatrix voltages(count, reference.size());
  RowMajorMatrix classes(count, first.classes.size());
  parallel_for(static_cast<std::size_t>(count), threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const Example made = example(tank, reference, i);
      voltages.row(static_cast<Eigen::Index>(i)) = reference + made.change;
      classes.row(static_cast<Eigen::Index>(i)) = made.classes;
    }
  });
  std::filesystem::create_directories(folder);
  replace_file(file, [&](const std::filesystem::path& aside) {
    Hdf5File out = Hdf5File::create(aside);
    const auto grid = static_cast<std::uint64_t>(sensor.image_grid);
    out.write_vector("/reference_voltages", reference);
    out.write_matrix("/voltages", voltages);
    out.create_dataset("/conductivity", {static_cast<std::uint64_t>(count), grid, grid});
    out.write_rows("/conductivity", 0, classes);
    out.close();
  });
  return file;
}

}  // namespace ertbench
