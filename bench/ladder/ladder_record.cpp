#include "bench/ladder/ladder_record.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "bench/record/cache.h"
#include "core/random.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The share of failing frames at each level, a frame counting `weights` times.
std::vector<double> shares(std::span<const LadderStep> ladder, const std::vector<int>& weights) {
  std::vector<double> out;
  for (const LadderStep& step : ladder) {
    int failed = 0;
    for (std::size_t f = 0; f < weights.size(); ++f) failed += weights[f] * step.failed[f];
    out.push_back(failed / static_cast<double>(weights.size()));
  }
  return out;
}

/// Position, in levels from the first, where the share first exceeds the limit: -infinity if
/// already at the first level, infinity if nowhere.
double crossing(const std::vector<double>& shares, double limit, Between between) {
  if (shares.front() > limit) return -infinity;
  for (std::size_t i = 1; i < shares.size(); ++i) {
    if (shares[i] <= limit) continue;
    if (between == Between::nothing) return static_cast<double>(i);
    return static_cast<double>(i - 1) + (limit - shares[i - 1]) / (shares[i] - shares[i - 1]);
  }
  return infinity;
}

/// The level there.
double level_at(std::span<const LadderStep> ladder, double place, Between between) {
  const auto last = static_cast<double>(ladder.size() - 1);
  const auto below =
      std::min(static_cast<std::size_t>(std::clamp(place, 0.0, last)), ladder.size() - 2);
  const double weight = std::clamp(place, 0.0, last) - static_cast<double>(below);
  const double a = ladder[below].level;
  const double b = ladder[below + 1].level;
  if (between == Between::logarithmic) return a * std::pow(b / a, weight);
  return a + weight * (b - a);
}

std::optional<double> if_within(std::span<const LadderStep> ladder, double place, Between between) {
  if (std::isinf(place)) return std::nullopt;
  return level_at(ladder, place, between);
}

void check(std::span<const LadderStep> ladder, Between between) {
  const auto refuse = [](const char* what) {
    throw std::invalid_argument(std::string("ladder: ") + what);
  };
  if (ladder.size() < 2) refuse("needs two levels at least");
  const bool rises = ladder[1].level > ladder[0].level;
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    if (ladder[i].failed.empty() || ladder[i].failed.size() != ladder[0].failed.size()) {
      refuse("needs the same frames at every level, one at least");
    }
    if (between == Between::logarithmic && !(ladder[i].level > 0))
      refuse("a logarithmic one needs levels > 0");
    if (i == 0) continue;
    const double step = ladder[i].level - ladder[i - 1].level;
    if (!(rises ? step > 0 : step < 0)) refuse("levels must rise, or fall, throughout");
  }
}

/// Raised whenever frames are judged or reported differently, or the layout changes.
constexpr int ladder_schema = 2;

json number_json(const std::optional<double>& value) {
  if (!value || !std::isfinite(*value)) return nullptr;
  return std::strtod(with_digits(*value, 5).c_str(), nullptr);
}

constexpr std::pair<const char*, std::optional<double> JudgedFrame::*> frame_numbers[] = {
    {"error", &JudgedFrame::error},
    {"distance", &JudgedFrame::distance},
    {"peak", &JudgedFrame::peak}};

json level_json(const LadderLevel& level) {
  json out = {{"level", level.level.json()}, {"status", json::array()}, {"failed", json::array()}};
  if (!level.message.empty()) out["message"] = level.message;
  for (const auto& [key, member] : frame_numbers) {
    out[key] = json::array();
    for (const JudgedFrame& frame : level.frames) out[key].push_back(number_json(frame.*member));
  }
  for (const JudgedFrame& frame : level.frames) {
    out["status"].push_back(static_cast<int>(frame.status));
    out["failed"].push_back(frame.failed);
  }
  return out;
}

LadderLevel level_from(const json& object) {
  LadderLevel level;
  level.level = object.at("level");
  level.message = object.value("message", "");
  for (std::size_t i = 0; i < object.at("failed").size(); ++i) {
    JudgedFrame frame;
    for (const auto& [key, member] : frame_numbers) {
      const json& value = object.at(key).at(i);
      if (!value.is_null()) frame.*member = value.get<double>();
    }
    frame.status = static_cast<FrameStatus>(object.at("status").at(i).get<int>());
    frame.failed = object.at("failed").at(i).get<int>();
    level.frames.push_back(frame);
  }
  return level;
}

}  // namespace

double LadderStep::share() const {
  return std::accumulate(failed.begin(), failed.end(), 0.0) / static_cast<double>(failed.size());
}

Breakdown break_down(std::span<const LadderStep> ladder, double share, Between between,
                     std::string_view name) {
  check(ladder, between);
  const std::size_t frames = ladder.front().failed.size();
  std::vector<int> weights(frames, 1);
  const double place = crossing(shares(ladder, weights), share, between);
  Breakdown out;
  out.state = std::isinf(place) ? (place < 0 ? BreakState::at_mildest : BreakState::never)
                                : BreakState::breaks;
  out.level = level_at(ladder, place, between);
  const auto scaled = [&](double level) {
    return between == Between::logarithmic ? std::log(level) : level;
  };
  const double first = scaled(ladder.front().level);
  out.place = (scaled(out.level) - first) / (scaled(ladder.back().level) - first);

  std::vector<double> places;
  for (std::uint64_t resample = 0; resample < kBreakdownResamples; ++resample) {
    RandomStream random(0, key_of(name), resample, Purpose::scene);
    std::ranges::fill(weights, 0);
    for (std::size_t f = 0; f < frames; ++f) {
      ++weights[static_cast<std::size_t>(random.uniform() * static_cast<double>(frames))];
    }
    places.push_back(crossing(shares(ladder, weights), share, between));
  }
  std::ranges::sort(places);
  constexpr std::size_t tail = kBreakdownResamples / 40;  // 2.5 %
  out.mild = if_within(ladder, places[tail], between);
  out.severe = if_within(ladder, places[places.size() - 1 - tail], between);
  return out;
}

WorkingRange working_range(std::span<const LadderStep> ladder, double share, Between between,
                           std::string_view name) {
  check(ladder, between);
  double least = infinity;
  for (const LadderStep& step : ladder) least = std::min(least, step.share());
  std::vector<std::size_t> best;
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    if (ladder[i].share() == least) best.push_back(i);
  }
  WorkingRange out;
  out.best = best[best.size() / 2];
  if (out.best > 0) {
    std::vector<LadderStep> down(ladder.begin(),
                                 ladder.begin() + static_cast<std::ptrdiff_t>(out.best) + 1);
    std::ranges::reverse(down);
    out.to_first = break_down(down, share, between, name);
  }
  if (out.best + 1 < ladder.size()) {
    out.to_last = break_down(ladder.subspan(out.best), share, between, name);
  }
  return out;
}

double LadderLevel::share() const {
  if (frames.empty()) return 1;
  const auto failed =
      std::ranges::count_if(frames, [](const JudgedFrame& frame) { return frame.failed != 0; });
  return static_cast<double>(failed) / static_cast<double>(frames.size());
}

int LadderLevel::count(FailureKind kind) const {
  return static_cast<int>(
      std::ranges::count_if(frames, [&](const JudgedFrame& frame) { return frame.has(kind); }));
}

LadderStep LadderLevel::step(std::size_t count) const {
  LadderStep out{level.number(), std::vector<std::uint8_t>(count, 1)};
  for (std::size_t f = 0; f < std::min(count, frames.size()); ++f) {
    out.failed[f] = frames[f].failed != 0;
  }
  return out;
}

const LadderClimb* LadderRecord::find(const std::string& axis) const {
  const auto found = std::ranges::find(axes, axis, &LadderClimb::axis);
  return found == axes.end() ? nullptr : &*found;
}

std::string ladder_key(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base) {
  const FailureRule& rule = ladders.failure;
  json key = {
      {"schema", ladder_schema},
      {"label", recipe.entry.label},
      {"entry", recipe.entry.spec.text()},
      {"solver", Cache::fitted_solver_key(recipe).dump()},
      {"dataset", to_json(base)},
      {"failure", {rule.relative_error, rule.distance, rule.contact_threshold, rule.share}}};
  for (const LadderAxis& axis : ladders.axes) {
    if (axis.concerns(recipe.entry)) key["axes"].push_back(*axis.spec);
  }
  return hash_of(key.dump());
}

json to_json(const LadderRecord& record) {
  json out = {
      {"schema", ladder_schema}, {"base", level_json(record.base)}, {"axes", json::array()}};
  for (const LadderClimb& climb : record.axes) {
    json axis = {{"axis", climb.axis}, {"levels", json::array()}};
    for (const LadderLevel& level : climb.levels) axis["levels"].push_back(level_json(level));
    out["axes"].push_back(std::move(axis));
  }
  return out;
}

LadderRecord ladder_record_from_json(const json& object) {
  LadderRecord record;
  record.base = level_from(object.at("base"));
  for (const json& axis : object.at("axes")) {
    LadderClimb& climb = record.axes.emplace_back();
    climb.axis = axis.at("axis").get<std::string>();
    for (const json& level : axis.at("levels")) climb.levels.push_back(level_from(level));
  }
  return record;
}

}  // namespace ertbench
