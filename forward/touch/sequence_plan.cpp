#include "forward/touch/sequence_plan.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/json_reader.h"
#include "forward/sheet/sensor.h"
#include "forward/touch/characters.h"
#include "forward/touch/touch_distribution.h"

namespace ertbench {

using Eigen::Vector2d;

namespace {

constexpr double drawn_box_mm = 120;  ///< that characters are drawn in
constexpr const char* usual_symbols = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ";

// How many sequences a plan has, how long each is, and what happens in it.

std::uint64_t count_of(const PressPlan& plan) {
  return static_cast<std::uint64_t>(plan.areas * plan.areas * plan.repeats);
}

TouchSequence draw_one(const PressPlan& plan, std::uint64_t sequence, RandomStream& random,
                       const Sensor& sensor) {
  const double side = sensor.sheet->size_mm().x() / plan.areas;
  const PlaceGrid areas{plan.areas, plan.areas, {side, side}, {0, 0}};
  const int area = static_cast<int>(sequence % static_cast<std::uint64_t>(areas.count()));
  const double x = random.uniform(-plan.jitter_mm, plan.jitter_mm);
  const double y = random.uniform(-plan.jitter_mm, plan.jitter_mm);
  const Vector2d place = areas.place_mm(area) + Vector2d(x, y);
  TouchSequence out;
  out.name = std::to_string(area + 1);
  TouchPath path{plan.indenter, {{0, place, 0}}};
  double start = 0;
  for (const double force : plan.steps()) {
    path.points.push_back({start + plan.ramp_s, place, force});
    start += plan.hold_s;
    path.points.push_back({start, place, force});
  }
  out.duration_s = start;
  out.paths = {std::move(path)};
  return out;
}

std::uint64_t count_of(const WritePlan& plan) {
  return plan.characters.size() * static_cast<std::uint64_t>(plan.repeats);
}

TouchSequence draw_one(const WritePlan& plan, std::uint64_t sequence, RandomStream&,
                       const Sensor&) {
  const Character& drawn = character(plan.characters[sequence % plan.characters.size()]);
  const double scale = plan.size_mm / drawn_box_mm;
  TouchSequence out;
  out.name = std::string(1, drawn.symbol);
  double time = 0;
  Vector2d pen = Vector2d::Zero();
  for (const auto& stroke : drawn.strokes) {
    const Vector2d start = scale * stroke.front();
    if (!out.paths.empty()) time += (start - pen).norm() / plan.speed_mm_s;
    TouchPath path{plan.indenter, {{time, start, plan.force_N}}};
    time += plan.still_s;
    pen = start;
    for (const Vector2d& point : stroke) {
      const Vector2d next = scale * point;
      time += (next - pen).norm() / plan.speed_mm_s;
      pen = next;
      if (path.points.back().time_s < time) path.points.push_back({time, pen, plan.force_N});
    }
    time += plan.still_s;
    path.points.push_back({time, pen, plan.force_N});
    out.paths.push_back(std::move(path));
  }
  out.duration_s = time;
  return out;
}

std::uint64_t count_of(const CollidePlan& plan) {
  return static_cast<std::uint64_t>(plan.sequences);
}

TouchSequence draw_one(const CollidePlan& plan, std::uint64_t, RandomStream& random,
                       const Sensor& sensor) {
  const double reach = sensor.sheet->size_mm().x() / 2 - plan.margin_mm;
  const bool touched = random.uniform() < plan.touched_fraction;
  const double x = random.uniform(-reach, reach);
  const double y = random.uniform(-reach, reach);
  const double onset = random.uniform(plan.onset_s.first, plan.onset_s.second);
  const double rate = random.uniform(plan.rate_N_s.first, plan.rate_N_s.second);
  const double force = random.uniform(plan.force_N.first, plan.force_N.second);
  TouchSequence out;
  out.duration_s = plan.duration_s;
  if (!touched) return out;
  const Vector2d place(x, y);
  const double grown = onset + force / rate;
  out.paths = {{plan.indenter,
                {{onset, place, 0},
                 {grown, place, force},
                 {std::max(grown, plan.duration_s), place, force}}}};
  return out;
}

/// Of any sensor: no plan's durations depend on it, nor on random numbers.
double duration_s(const SequencePlan& plan, std::uint64_t sequence) {
  RandomStream random(0, 0, sequence, Purpose::scene);
  return std::visit(
      [&](const auto& one) { return draw_one(one, sequence, random, Sensor{}).duration_s; }, plan);
}

PressPlan press_plan_from_json(JsonObject& object, double side_mm) {
  PressPlan plan;
  plan.areas = object.integer_or("areas", plan.areas, 1, 50);
  plan.repeats = object.integer_or("repeats", 1, 1, 100000);
  if (object.has("forces_N")) {
    plan.forces_N.clear();
    const nlohmann::json& forces = object.raw("forces_N");
    for (std::size_t i = 0; forces.is_array() && i < forces.size(); ++i) {
      if (!forces[i].is_number() || !(forces[i].get<double>() > 0) ||
          (i > 0 && forces[i] <= forces[i - 1])) {
        plan.forces_N.clear();
        break;
      }
      plan.forces_N.push_back(forces[i]);
    }
    if (plan.forces_N.empty()) object.fail("forces_N", "must be ascending numbers of newton, > 0");
  }
  plan.hold_s = object.number_or("hold_s", plan.hold_s, {1e-3, 1e4, false, "s"});
  plan.ramp_s = object.number_or("ramp_s", std::min(plan.ramp_s, plan.hold_s / 2),
                                 {1e-6, plan.hold_s, false, "s"});
  plan.jitter_mm = object.number_or("jitter_mm", 0, {0, side_mm / (2.0 * plan.areas), false, "mm"});
  return plan;
}

WritePlan write_plan_from_json(JsonObject& object, double side_mm) {
  WritePlan plan;
  plan.characters = object.text_or("characters", usual_symbols);
  if (plan.characters.empty()) object.fail("characters", "must hold at least one");
  for (const char symbol : plan.characters) {
    if (std::string_view(usual_symbols).find(symbol) == std::string_view::npos) {
      object.fail("characters", std::string("must be of ") + usual_symbols);
    }
  }
  plan.repeats = object.integer_or("repeats", 1, 1, 100000);
  plan.speed_mm_s = object.number_or("speed_mm_s", plan.speed_mm_s, {0.01, 1e5, false, "mm/s"});
  plan.size_mm = object.number_or("size_mm", 0.6 * side_mm, {1, side_mm, false, "mm"});
  plan.force_N = object.number_or("force_N", plan.force_N, {1e-6, 1e4, false, "N"});
  plan.still_s = object.number_or("still_s", plan.still_s, {0, 100, false, "s"});
  plan.indenter.body = FlatFace{{8, 10}, 0, {}};
  return plan;
}

CollidePlan collide_plan_from_json(JsonObject& object, double side_mm) {
  CollidePlan plan;
  plan.sequences = object.integer("sequences", 1, 10000000);
  plan.duration_s = object.number("duration_s", {1e-3, 1e6, false, "s"});
  plan.touched_fraction = object.number_or("touched_fraction", 1, {0, 1});
  if (object.has("onset_s")) {
    plan.onset_s = object.interval("onset_s", {0, plan.duration_s, false, "s"});
  } else {
    plan.onset_s = {plan.duration_s / 4, plan.duration_s / 2};
  }
  if (object.has("rate_N_s")) {
    plan.rate_N_s = object.interval("rate_N_s", {1e-3, 1e9, false, "N/s"});
  }
  if (object.has("force_N")) plan.force_N = object.interval("force_N", {1e-6, 1e4, false, "N"});
  plan.margin_mm = object.number_or("margin_mm", plan.margin_mm, {0, 0.45 * side_mm, false, "mm"});
  plan.indenter.body = Sphere{20};
  return plan;
}

nlohmann::json json_of(const PressPlan& plan) {
  return {{"sequence", "press"},        {"areas", plan.areas},   {"repeats", plan.repeats},
          {"forces_N", plan.forces_N},  {"hold_s", plan.hold_s}, {"ramp_s", plan.ramp_s},
          {"jitter_mm", plan.jitter_mm}};
}

nlohmann::json json_of(const WritePlan& plan) {
  return {{"sequence", "write"},     {"characters", plan.characters},
          {"repeats", plan.repeats}, {"speed_mm_s", plan.speed_mm_s},
          {"size_mm", plan.size_mm}, {"force_N", plan.force_N},
          {"still_s", plan.still_s}};
}

nlohmann::json json_of(const CollidePlan& plan) {
  const auto both = [](const auto& interval) {
    return nlohmann::json{interval.first, interval.second};
  };
  return {{"sequence", "collide"},         {"sequences", plan.sequences},
          {"duration_s", plan.duration_s}, {"touched_fraction", plan.touched_fraction},
          {"onset_s", both(plan.onset_s)}, {"rate_N_s", both(plan.rate_N_s)},
          {"force_N", both(plan.force_N)}, {"margin_mm", plan.margin_mm}};
}

}  // namespace

std::vector<double> PressPlan::steps() const {
  std::vector<double> out = forces_N;
  out.insert(out.end(), forces_N.rbegin() + 1, forces_N.rend());
  return out;
}

SequenceSet::SequenceSet(SequencePlan plan, FrameTiming timing)
    : plan_(std::move(plan)), timing_(timing), first_{0} {
  const std::uint64_t count = std::visit([](const auto& one) { return count_of(one); }, plan_);
  first_.reserve(count + 1);
  const bool same = std::holds_alternative<CollidePlan>(plan_);
  double duration = duration_s(plan_, 0);
  for (std::uint64_t s = 0; s < count; ++s) {
    if (!same) duration = duration_s(plan_, s);
    // A frame that ends with the sequence, but for rounding, is one of it.
    const double frames = std::floor(duration * timing_.frame_rate + 1e-6);
    first_.push_back(first_.back() + static_cast<std::uint64_t>(std::max(1.0, frames)));
  }
}

std::uint64_t SequenceSet::sequence_of(std::uint64_t frame) const {
  const auto next = std::upper_bound(first_.begin(), first_.end(), frame);
  return static_cast<std::uint64_t>(next - first_.begin()) - 1;
}

TouchSequence SequenceSet::draw(std::uint64_t sequence, RandomStream& random,
                                const Sensor& sensor) const {
  return std::visit([&](const auto& plan) { return draw_one(plan, sequence, random, sensor); },
                    plan_);
}

SequenceSet sequence_set_from_json(JsonObject object, const Sensor& sensor) {
  if (!sensor.skin) {
    object.fail("sequence", R"(needs a sensor with a skin: give "sensor" a "skin", such as {})");
  }
  const double side_mm = sensor.sheet->size_mm().x();
  const std::string kind = object.choice("sequence", {"press", "write", "collide"});
  SequencePlan plan;
  if (kind == "press") plan = press_plan_from_json(object, side_mm);
  if (kind == "write") plan = write_plan_from_json(object, side_mm);
  if (kind == "collide") plan = collide_plan_from_json(object, side_mm);
  if (object.has("indenter")) {
    const Indenter indenter = indenter_from_json(object.object("indenter"));
    std::visit([&](auto& one) { one.indenter = indenter; }, plan);
  }
  FrameTiming timing;
  timing.frame_rate = object.number_or("frame_rate", timing.frame_rate, {1e-3, 1e5, false, "1/s"});
  const double longest_ms = 1000 / (timing.frame_rate * sensor.drives());
  timing.drive_time_s = object.number_or("drive_time_ms", std::min(0.5, longest_ms),
                                         {1e-6, longest_ms * (1 + 1e-9), false, "ms"}) /
                        1000;
  object.finish();
  return {std::move(plan), timing};
}

nlohmann::json to_json(const SequenceSet& set) {
  nlohmann::json json = std::visit([](const auto& plan) { return json_of(plan); }, set.plan());
  json["indenter"] =
      std::visit([](const auto& plan) { return to_json(plan.indenter); }, set.plan());
  json["frame_rate"] = set.timing().frame_rate;
  json["drive_time_ms"] = 1000 * set.timing().drive_time_s;
  return json;
}

}  // namespace ertbench
