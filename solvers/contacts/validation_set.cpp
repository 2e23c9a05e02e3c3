#include "solvers/contacts/validation_set.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

namespace ertbench {
namespace {

/// A set without noise is taken to have this part of the reference voltages, 80 dB.
constexpr double least_noise = 1e-4;

/// Whether the frames were read and not generated, so that nobody knows what they would be without
/// noise.
bool is_measured(const DatasetFile& set) {
  return nlohmann::json::parse(set.recipe(), nullptr, false).contains("file");
}

}  // namespace

std::optional<double> noise_of_channel(const DatasetFile& set, ElectrodeSet masked) {
  const Frames voltages = set.voltages(0, std::min(set.size(), judged_frames));
  double sum = 0;
  double count = 0;
  const auto pairs = reciprocal_pairs(set.sensor());
  const auto electrodes = electrodes_of_pairs(set.sensor());
  const bool single = !is_reciprocal(set.sensor());
  // Where no two channels measure the same, the simulated set knows its noise.
  const Frames clean =
      single ? set.clean_voltages(0, std::min(set.size(), judged_frames)) : Frames();
  for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
    if (single) {
      sum += (voltages.row(f) - clean.row(f)).squaredNorm();
      count += static_cast<double>(pairs.size());
      continue;
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if ((electrodes[p] & masked) != 0) continue;
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
