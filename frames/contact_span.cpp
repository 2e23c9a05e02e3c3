#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "core/kept.h"
#include "core/lists.h"
#include "forward/border/border_model.h"
#include "forward/sheet/sensor_json.h"
#include "frames/reference_check.h"
#include "solvers/channel_mask.h"
#include "solvers/decompositions.h"

namespace ertbench {
namespace {

constexpr double zero_share = 0.1;

}  // namespace

std::vector<int> electrodes_with_bad_channels(const Sensor& sensor,
                                              const std::function<bool(Eigen::Index)>& is_bad) {
  constexpr double nearly_all = 0.8;
  const std::vector<ChannelElectrodes> channels = electrodes_of_channels(sensor);
  const auto electrodes = static_cast<std::size_t>(sensor.electrode_count);
  std::vector<int> used(electrodes, 0);
  std::vector<int> bad(electrodes, 0);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const bool channel_is_bad = is_bad(static_cast<Eigen::Index>(c));
    for (const auto& pair : {channels[c].drive, channels[c].measurement}) {
      for (const int e : {pair.first, pair.second}) {
        ++used[static_cast<std::size_t>(e)];
        bad[static_cast<std::size_t>(e)] += channel_is_bad;
      }
    }
  }
  std::vector<int> out;
  for (std::size_t e = 0; e < electrodes; ++e) {
    if (used[e] > 0 && bad[e] >= nearly_all * used[e]) out.push_back(static_cast<int>(e));
  }
  return out;
}

std::vector<int> electrodes_reading_zero(const Sensor& sensor, const Eigen::VectorXd& reference,
                                         const Eigen::VectorXd& expected) {
  return electrodes_with_bad_channels(sensor, [&](Eigen::Index c) {
    return std::abs(reference[c]) < zero_share * std::abs(expected[c]);
  });
}

Eigen::VectorXd filled_reference(const Sensor& sensor, const Eigen::VectorXd& reference,
                                 const Eigen::VectorXd& expected) {
  const Eigen::VectorXd usual = reference.norm() / expected.norm() * expected;
  const std::vector<int> dead = electrodes_reading_zero(sensor, reference, usual);
  Eigen::VectorXd out = reference;
  if (dead.empty() || 2 * std::ssize(dead) >= sensor.electrode_count) return out;
  ElectrodeSet lost = 0;
  for (const int e : dead) lost |= ElectrodeSet{1} << e;
  const std::vector<ElectrodeSet> users = electrode_sets_of_channels(sensor);
  for (Eigen::Index c = 0; c < out.size(); ++c) {
    const bool is_zero = std::abs(reference[c]) < zero_share * std::abs(usual[c]);
    if (is_zero && (users[static_cast<std::size_t>(c)] & lost)) out[c] = expected[c];
  }
  return out;
}

std::vector<int> channels_that_never_change(const Frames& frames) {
  std::vector<int> out;
  if (frames.rows() < 3) return out;
  for (Eigen::Index c = 0; c < frames.cols(); ++c) {
    if ((frames.col(c).array() == frames(0, c)).all()) out.push_back(static_cast<int>(c));
  }
  if (2 * std::ssize(out) > frames.cols()) out.clear();
  return out;
}

std::string text_of_channels(const Sensor& sensor, const std::vector<int>& list) {
  constexpr std::size_t most = 4;
  const std::vector<Channel> channels = channels_of(sensor);
  const auto text = [&](int c) {
    const Channel& channel = channels[static_cast<std::size_t>(c)];
    return std::to_string(c) + " (drive " + std::to_string(channel.drive) + ", measurement " +
           std::to_string(channel.measurement) + ")";
  };
  const std::string out = (list.size() == 1 ? "channel " : "channels ") +
                          joined(std::span(list).first(std::min(most, list.size())), ", ", text);
  return list.size() > most ? out + " and " + std::to_string(list.size() - most) + " more" : out;
}

namespace {

constexpr int discs_across = 21;
constexpr double disc_radii[] = {0.12, 0.05};  ///< of the sheet's inner radius
constexpr double disc_ratio = 0.5;
constexpr double resolution = 0.7;
constexpr double least_value = 0.003;  ///< of the largest singular value

Eigen::MatrixXd contact_basis(const Sensor& sensor) {
  const BorderModel model(sensor);
  const PixelGrid places(sensor.sheet->bounds(), discs_across, discs_across);
  std::vector<Eigen::VectorXd> changes;
  for (const double share : disc_radii) {
    const double radius = share * sensor.sheet->inner_radius();
    for (int p = 0; p < places.count(); ++p) {
      Contact disc;
      disc.centre = places.centre(p);
      if (sensor.sheet->depth(disc.centre) < 1.2 * radius) continue;
      disc.half_size = {radius, radius};
      disc.conductivity_ratio = disc_ratio;
      changes.push_back(model.solve_at({{disc}}, resolution).change);
    }
  }
  Eigen::MatrixXd columns(sensor.channels(), static_cast<Eigen::Index>(changes.size()));
  for (std::size_t i = 0; i < changes.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = changes[i];
  }
  const DenseSvd svd = dense_svd(columns);
  const Eigen::VectorXd& values = svd.values;
  Eigen::Index kept = 0;
  while (kept < values.size() && values[kept] > least_value * values[0]) ++kept;
  return svd.left.leftCols(kept);
}

}  // namespace

ContactSpan::ContactSpan(const Sensor& sensor)
    : basis_(kept_matrix("contact-span", to_json(sensor).dump(),
                         [&] { return contact_basis(sensor); })) {}

double ContactSpan::share(const Frames& changes) const {
  const double all = changes.squaredNorm();
  return all > 0 ? (changes * basis_).squaredNorm() / all : 0;
}

Eigen::RowVectorXd ContactSpan::rest(const Eigen::Ref<const Eigen::RowVectorXd>& change) const {
  return change - (change * basis_) * basis_.transpose();
}

}  // namespace ertbench
