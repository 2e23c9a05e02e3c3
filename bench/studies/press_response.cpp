#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "bench/studies/error_statistics.h"
#include "bench/studies/sensitivity.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

std::size_t force_index(const std::vector<double>& forces, double force) {
  const auto found =
      std::ranges::min_element(forces, {}, [&](double one) { return std::abs(one - force); });
  return static_cast<std::size_t>(found - forces.begin());
}

/// The means with neighbours that fall joined until none falls (pool adjacent violators).
std::vector<double> made_monotone(const std::vector<double>& means) {
  std::vector<WeightedPoint> points;
  for (const double mean : means) points.push_back({static_cast<double>(points.size()), mean, 1});
  std::vector<double> out;
  for (const IsotonicBlock& block : isotonic_fit(points)) {
    out.insert(out.end(), static_cast<std::size_t>(block.weight), block.value);
  }
  return out;
}

/// The steps of one region.
class RegionSteps {
 public:
  /// `presses`: in all regions.
  RegionSteps(const std::vector<PressStep>& steps, std::size_t presses, int region,
              const std::vector<int>& region_of, Strength strength,
              const std::vector<double>& forces)
      : strength_(strength), forces_(forces), presses_(presses) {
    for (const PressStep& step : steps) {
      if (region_of[static_cast<std::size_t>(step.area)] == region) steps_.push_back(&step);
    }
  }

  PressResponse::Curve curve(const std::string& key) const {
    PressResponse::Curve out;
    for (std::size_t f = 0; f < forces_.size(); ++f) {
      out.rising.push_back(mean_at(f, true, key));
      out.falling.push_back(mean_at(f, false, key));
    }
    out.spread = spread();
    std::map<std::size_t, Press> by_press;
    for (const PressStep* step : steps_) by_press[step->press].push_back(step);
    GroupedErrors steps_up(presses_);
    GroupedErrors loops(presses_);
    for (const auto& [press, steps] : by_press) {
      add_steps_up(steps, press, steps_up);
      add_loop(steps, press, loops);
    }
    out.monotone = steps_up.mean(key + "monotone");
    out.hysteresis = loops.mean(key + "hysteresis");
    return out;
  }

 private:
  using Press = std::vector<const PressStep*>;

  std::optional<Estimate> mean_at(std::size_t force, bool rising, const std::string& key) const {
    GroupedErrors values(presses_);
    for (const PressStep* step : steps_) {
      const auto value = step->value(strength_);
      if (step->rising != rising || !value) continue;
      if (force_index(forces_, step->force_N) == force) values.add(step->press, *value);
    }
    return values.mean(key + std::to_string(force) + (rising ? "up" : "down"));
  }

  /// Between the areas of the region, at the largest force.
  double spread() const {
    std::map<int, std::vector<double>> areas;
    for (const PressStep* step : steps_) {
      const auto value = step->value(strength_);
      if (value && step->force_N == forces_.back()) areas[step->area].push_back(*value);
    }
    std::vector<double> means;
    for (const auto& [area, values] : areas) means.push_back(mean(values));
    return means.size() < 2 ? 0 : sample_deviation(means) / std::abs(mean(means));
  }

  void add_steps_up(const Press& steps, std::size_t group, GroupedErrors& out) const {
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
      const auto a = steps[i]->value(strength_);
      const auto b = steps[i + 1]->value(strength_);
      if (!steps[i + 1]->rising || !a || !b) continue;
      out.add(group, *b > *a ? 1 : 0);
    }
  }

  /// Mean of falling less rising strength at the same force, over the span of the rising ones.
  void add_loop(const Press& steps, std::size_t group, GroupedErrors& out) const {
    std::map<std::size_t, double> rising;
    std::map<std::size_t, double> falling;
    for (const PressStep* step : steps) {
      const auto value = step->value(strength_);
      if (!value) continue;
      (step->rising ? rising : falling)[force_index(forces_, step->force_N)] = *value;
    }
    if (rising.size() < 2) return;
    const double span = rising.rbegin()->second - rising.begin()->second;
    double sum = 0;
    int count = 0;
    for (const auto& [force, value] : falling) {
      const auto up = rising.find(force);
      if (up == rising.end()) continue;
      sum += value - up->second;
      ++count;
    }
    if (count > 0 && span > 0) out.add(group, sum / count / span);
  }

  Strength strength_;
  const std::vector<double>& forces_;
  std::size_t presses_;
  Press steps_;
};

}  // namespace

ForceCalibration::ForceCalibration(const std::vector<PressStep>& steps, Strength strength,
                                   const std::vector<int>& region_of) {
  const int regions = *std::ranges::max_element(region_of) + 1;
  regions_.resize(static_cast<std::size_t>(regions));
  for (int region = 0; region < regions; ++region) {
    std::map<double, std::vector<double>> by_force;
    for (const PressStep& step : steps) {
      const auto value = step.value(strength);
      if (value && region_of[static_cast<std::size_t>(step.area)] == region) {
        by_force[step.force_N].push_back(*value);
      }
    }
    std::vector<double> forces;
    std::vector<double> means;
    for (const auto& [force, values] : by_force) {
      forces.push_back(force);
      means.push_back(mean(values));
    }
    means = made_monotone(means);
    // Forces of equal strength cannot be distinguished: their mean stands for them.
    std::vector<Knot>& knots = regions_[static_cast<std::size_t>(region)];
    for (std::size_t i = 0; i < means.size();) {
      std::size_t end = i;
      double force = 0;
      while (end < means.size() && means[end] == means[i]) force += forces[end++];
      knots.push_back({means[i], force / static_cast<double>(end - i)});
      i = end;
    }
  }
}

std::optional<double> ForceCalibration::force_N(int region, double strength) const {
  const std::vector<Knot>& knots = regions_[static_cast<std::size_t>(region)];
  if (knots.empty()) return std::nullopt;
  if (strength <= knots.front().strength) return knots.front().force;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    if (strength > knots[i + 1].strength) continue;
    const double part =
        (strength - knots[i].strength) / (knots[i + 1].strength - knots[i].strength);
    return knots[i].force + part * (knots[i + 1].force - knots[i].force);
  }
  return knots.back().force;
}

PressResponse press_response(const std::vector<PressStep>& steps,
                             const std::vector<PressStep>& calibration,
                             const std::vector<double>& forces_N, const std::vector<int>& region_of,
                             const std::string& key) {
  PressResponse out;
  const int regions = *std::ranges::max_element(region_of) + 1;
  std::size_t presses = 0;
  for (const PressStep& step : steps) presses = std::max(presses, step.press + 1);
  for (const Strength strength : kStrengths) {
    PressResponse::Reading& reading = out.readings[static_cast<std::size_t>(strength)];
    for (int region = 0; region < regions; ++region) {
      const std::string name = key + name_of(strength) + std::to_string(region);
      reading.regions.push_back(
          RegionSteps(steps, presses, region, region_of, strength, forces_N).curve(name));
    }
    const ForceCalibration force(calibration, strength, region_of);
    GroupedErrors all(presses);
    std::vector<GroupedErrors> at(forces_N.size(), GroupedErrors(presses));
    for (const PressStep& step : steps) {
      const auto value = step.value(strength);
      std::optional<double> read;
      if (value && step.found_area) {
        read = force.force_N(region_of[static_cast<std::size_t>(*step.found_area)], *value);
      }
      if (!read) {
        ++reading.unlocated;
        continue;
      }
      const double error = std::abs(*read - step.force_N);
      all.add(step.press, error);
      at[force_index(forces_N, step.force_N)].add(step.press, error);
    }
    const std::string name = key + name_of(strength);
    reading.force_error = all.mean(name + "force");
    for (std::size_t f = 0; f < forces_N.size(); ++f) {
      reading.force_error_at.push_back(at[f].mean(name + "force" + std::to_string(f)));
    }
  }
  return out;
}

}  // namespace ertbench
