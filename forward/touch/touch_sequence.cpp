#include "forward/touch/touch_sequence.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/fields.h"
#include "core/json.h"
#include "core/text.h"
#include "forward/sheet/sensor.h"
#include "forward/touch/touch_distribution.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

using Stroke = std::vector<Eigen::Vector2d>;

/// A stroke in the making: begins at a point and goes on along lines and arcs.
class Pen {
 public:
  Pen(double x, double y) : stroke_{{x, y}} {}

  Pen& to(double x, double y) {
    stroke_.emplace_back(x, y);
    return *this;
  }

  /// Along an ellipse around a centre from one direction to another, degrees counter-clockwise
  /// from x; a straight line leads to its beginning unless the pen stands there, within half a
  /// millimetre.
  Pen& arc(double x, double y, double radius_x, double radius_y, double from, double to) {
    constexpr double largest_step = 6;
    const int steps = static_cast<int>(std::ceil(std::abs(to - from) / largest_step));
    for (int i = 0; i <= steps; ++i) {
      const double angle = (from + (to - from) * i / steps) * std::numbers::pi / 180;
      const Eigen::Vector2d point(x + radius_x * std::cos(angle), y + radius_y * std::sin(angle));
      if ((point - stroke_.back()).norm() > 0.5) stroke_.push_back(point);
    }
    return *this;
  }

  operator Stroke() const { return stroke_; }  // implicit: a list of pens is a list of strokes

 private:
  Stroke stroke_;
};

std::vector<Character> drawn_digits() {
  return {
      {'0', {Pen(0, 60).arc(0, 0, 36, 60, 90, 450), Pen(-24, -40).to(24, 40)}},
      {'1', {Pen(-28, 30).to(5, 60).to(5, -60)}},
      {'2', {Pen(-38, 26).arc(0, 26, 38, 34, 180, -35).to(-38, -60).to(40, -60)}},
      {'3', {Pen(-32, 45).arc(0, 30, 36, 30, 150, -90).arc(0, -30, 40, 30, 90, -150)}},
      {'4', {Pen(20, -60).to(20, 60).to(-45, -25).to(45, -25)}},
      {'5', {Pen(-28, 60).to(-34, 4).arc(-2, -20, 40, 40, 143, -140), Pen(-28, 60).to(36, 60)}},
      {'6', {Pen(28, 58).arc(28, -22, 66, 80, 90, 180).arc(0, -22, 38, 38, 180, 540)}},
      {'7', {Pen(-40, 60).to(40, 60).to(-12, -60)}},
      {'8', {Pen(0, 4).arc(0, 32, 30, 28, -90, 270).arc(0, -28, 40, 32, 90, -270)}},
      {'9', {Pen(38, 22).arc(0, 22, 38, 38, 0, 360).arc(-28, 22, 66, 82, 0, -90)}},
  };
}

std::vector<Character> drawn_letters() {
  return {
      {'A', {Pen(-50, -60).to(0, 60).to(50, -60), Pen(-33, -20).to(33, -20)}},
      {'B',
       {Pen(-36, -60)
            .to(-36, 60)
            .to(4, 60)
            .arc(4, 32, 28, 28, 90, -90)
            .to(-36, 4)
            .to(4, 4)
            .arc(4, -28, 34, 32, 90, -90)
            .to(-36, -60)}},
      {'C', {Pen(42, 38).arc(0, 0, 54, 60, 40, 320)}},
      {'D', {Pen(-40, -60).to(-40, 60).to(-10, 60).arc(-10, 0, 52, 60, 90, -90).to(-40, -60)}},
      {'E', {Pen(38, 60).to(-36, 60).to(-36, -60).to(38, -60), Pen(-36, 0).to(26, 0)}},
      {'F', {Pen(38, 60).to(-36, 60).to(-36, -60), Pen(-36, 2).to(26, 2)}},
      {'G', {Pen(42, 38).arc(0, 0, 54, 60, 40, 350).to(53, -6).to(12, -6)}},
      {'H', {Pen(-42, 60).to(-42, -60), Pen(42, 60).to(42, -60), Pen(-42, 0).to(42, 0)}},
      {'I', {Pen(-28, 60).to(28, 60), Pen(0, 60).to(0, -60), Pen(-28, -60).to(28, -60)}},
      {'J', {Pen(28, 60).to(28, -24).arc(-6, -24, 34, 36, 0, -170)}},
      {'K', {Pen(-38, 60).to(-38, -60), Pen(40, 60).to(-38, -8), Pen(-10, 16).to(42, -60)}},
      {'L', {Pen(-34, 60).to(-34, -60).to(40, -60)}},
      {'M', {Pen(-52, -60).to(-46, 60).to(0, -20).to(46, 60).to(52, -60)}},
      {'N', {Pen(-42, -60).to(-42, 60).to(42, -60).to(42, 60)}},
      {'O', {Pen(0, 60).arc(0, 0, 60, 60, 90, 450)}},
      {'P', {Pen(-36, -60).to(-36, 60).to(2, 60).arc(2, 28, 36, 32, 90, -90).to(-36, -4)}},
      {'Q', {Pen(0, 60).arc(0, 4, 56, 56, 90, 450), Pen(14, -18).to(54, -60)}},
      {'R',
       {Pen(-36, -60)
            .to(-36, 60)
            .to(2, 60)
            .arc(2, 29, 34, 31, 90, -90)
            .to(-36, -2)
            .to(-4, -2)
            .to(42, -60)}},
      {'S', {Pen(32, 44).arc(0, 30, 36, 30, 30, 270).arc(0, -30, 40, 30, 90, -150)}},
      {'T', {Pen(-48, 60).to(48, 60), Pen(0, 60).to(0, -60)}},
      {'U', {Pen(-42, 60).to(-42, -18).arc(0, -18, 42, 42, 180, 360).to(42, 60)}},
      {'V', {Pen(-46, 60).to(0, -60).to(46, 60)}},
      {'W', {Pen(-58, 60).to(-30, -60).to(0, 30).to(30, -60).to(58, 60)}},
      {'X', {Pen(-44, 60).to(44, -60), Pen(44, 60).to(-44, -60)}},
      {'Y', {Pen(-44, 60).to(0, 2).to(44, 60), Pen(0, 2).to(0, -60)}},
      {'Z', {Pen(-44, 60).to(44, 60).to(-44, -60).to(44, -60)}},
  };
}

std::vector<Character> all_characters() {
  std::vector<Character> all = drawn_digits();
  for (Character& letter : drawn_letters()) all.push_back(std::move(letter));
  return all;
}

constexpr double drawn_box_mm = 120;  ///< that characters are drawn in
constexpr const char* usual_symbols = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ";
constexpr Range forces{1e-6, 1e4, false, "N"};

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

/// Durations depend neither on the sensor nor on random numbers.
double duration_s(const SequencePlan& plan, std::uint64_t sequence) {
  RandomStream random(0, 0, sequence, Purpose::scene);
  return std::visit(
      [&](const auto& one) { return draw_one(one, sequence, random, Sensor{}).duration_s; }, plan);
}

void visit(Fields& fields, PressPlan& plan, double side_mm) {
  fields.integer("areas", plan.areas, 1, 50);
  fields.integer("repeats", plan.repeats, 1, 100000);
  fields.list("forces_N", plan.forces_N, Range::positive());
  if (!std::is_sorted(plan.forces_N.begin(), plan.forces_N.end(), std::less_equal<>())) {
    fields.fail("forces_N", "must be ascending numbers of newton, > 0");
  }
  fields.number("hold_s", plan.hold_s, {1e-3, 1e4, false, "s"});
  if (fields.reading()) plan.ramp_s = std::min(plan.ramp_s, plan.hold_s / 2);
  const double longest_s = fields.describing() ? INFINITY : plan.hold_s;
  fields.number("ramp_s", plan.ramp_s, {1e-6, longest_s, false, "s"});
  fields.number("jitter_mm", plan.jitter_mm, {0, side_mm / (2.0 * plan.areas), false, "mm"});
}

void visit(Fields& fields, WritePlan& plan, double side_mm) {
  if (fields.reading()) plan.size_mm = 0.6 * side_mm;
  fields.text("characters", plan.characters);
  if (plan.characters.find_first_not_of(usual_symbols) != std::string::npos) {
    fields.fail("characters", std::string("must be of ") + usual_symbols);
  }
  fields.integer("repeats", plan.repeats, 1, 100000);
  fields.number("speed_mm_s", plan.speed_mm_s, {0.01, 1e5, false, "mm/s"});
  fields.derived().number("size_mm", plan.size_mm, {1, side_mm, false, "mm"});
  fields.number("force_N", plan.force_N, forces);
  fields.number("still_s", plan.still_s, {0, 100, false, "s"});
}

void visit(Fields& fields, CollidePlan& plan, double side_mm) {
  fields.required().integer("sequences", plan.sequences, 1, 10000000);
  fields.required().number("duration_s", plan.duration_s, {1e-3, 1e6, false, "s"});
  fields.number("touched_fraction", plan.touched_fraction, {0, 1});
  if (fields.reading()) plan.onset_s = {plan.duration_s / 4, plan.duration_s / 2};
  const double end_s = fields.describing() ? INFINITY : plan.duration_s;
  fields.derived().interval("onset_s", plan.onset_s, {0, end_s, false, "s"});
  fields.interval("rate_N_s", plan.rate_N_s, {1e-3, 1e9, false, "N/s"});
  fields.interval("force_N", plan.force_N, forces);
  fields.number("margin_mm", plan.margin_mm, {0, 0.45 * side_mm, false, "mm"});
}

void visit(Fields& fields, SequencePlan& plan, double side_mm) {
  std::visit([&](auto& one) { visit(fields, one, side_mm); }, plan);
}

void visit(Fields& fields, FrameTiming& timing, int drives) {
  fields.number("frame_rate", timing.frame_rate, {1e-3, 1e5, false, "1/s"});
  const double longest_ms = 1000 / (timing.frame_rate * drives);
  double drive_time_ms = fields.reading() ? std::min(0.5, longest_ms) : 1000 * timing.drive_time_s;
  fields.derived().number("drive_time_ms", drive_time_ms,
                          {1e-6, longest_ms * (1 + 1e-9), false, "ms"});
  if (fields.reading()) timing.drive_time_s = drive_time_ms / 1000;
}

}  // namespace

const std::vector<Character>& characters() {
  static const std::vector<Character> all = all_characters();
  return all;
}

const Character& character(char symbol) {
  std::string known;
  for (const Character& one : characters()) {
    if (one.symbol == symbol) return one;
    known += one.symbol;
  }
  throw InputError("no character \"" + printable(std::string(1, symbol)) + "\"; there are " +
                   known);
}

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
    // A frame that ends with the sequence, up to rounding, belongs to it.
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
  const std::string kind = object.choice("sequence", {"press", "write", "collide"});
  SequencePlan plan;
  if (kind == "write") plan = WritePlan{};
  if (kind == "collide") plan = CollidePlan{};
  FrameTiming timing;
  Fields::read_some(object, [&](Fields& fields) {
    visit(fields, plan, sensor.sheet->size_mm().x());
    visit(fields, timing, sensor.drives());
  });
  if (object.has("indenter")) {
    const Indenter indenter = indenter_from_json(object.object("indenter"));
    std::visit([&](auto& one) { one.indenter = indenter; }, plan);
  }
  object.finish();
  return {std::move(plan), timing};
}

nlohmann::json to_json(const SequenceSet& set) {
  SequencePlan plan = set.plan();
  FrameTiming timing = set.timing();
  nlohmann::json json = Fields::written([&](Fields& fields) {
    visit(fields, plan, 0);
    visit(fields, timing, 1);
  });
  json["sequence"] = std::array{"press", "write", "collide"}[plan.index()];
  json["indenter"] = std::visit([](const auto& one) { return to_json(one.indenter); }, plan);
  return json;
}

nlohmann::ordered_json sequence_schema() {
  nlohmann::ordered_json schema = Fields::schema([](Fields& fields) {
    for (SequencePlan plan :
         {SequencePlan(PressPlan{}), SequencePlan(WritePlan{}), SequencePlan(CollidePlan{})}) {
      visit(fields, plan, INFINITY);
    }
    FrameTiming timing;
    visit(fields, timing, 0);
  });
  schema["required"] = {"sequence"};  // other keys are required of one kind alone
  return schema;
}

Touch TouchPath::at(double time_s) const {
  Touch touch{indenter, Eigen::Vector2d::Zero(), 0};
  if (points.empty() || time_s < points.front().time_s || time_s > points.back().time_s) {
    return touch;
  }
  const auto next =
      std::upper_bound(points.begin(), points.end(), time_s,
                       [](double time, const PathMoment& point) { return time < point.time_s; });
  if (next == points.begin() || next == points.end()) {
    const PathMoment& end = next == points.end() ? points.back() : points.front();
    return {indenter, end.place_mm, end.force_N};
  }
  const PathMoment& before = *std::prev(next);
  const double part = (time_s - before.time_s) / (next->time_s - before.time_s);
  touch.place_mm = before.place_mm + part * (next->place_mm - before.place_mm);
  touch.force_N = before.force_N + part * (next->force_N - before.force_N);
  return touch;
}

std::vector<Touch> TouchSequence::at(double time_s) const {
  std::vector<Touch> touches;
  touches.reserve(paths.size());
  for (const TouchPath& path : paths) touches.push_back(path.at(time_s));
  return touches;
}

}  // namespace ertbench
