#include "forward/data/measured_frames.h"

#include <nlohmann/json.hpp>
#include <numeric>

#include "core/errors.h"
#include "core/fields.h"
#include "core/files.h"
#include "core/random.h"
#include "core/text.h"
#include "forward/data/measured_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Default radius of a contact over the sheet's inner radius, if only the position is known.
constexpr double default_radius = 0.15;

/// Result of the inspection: `{"size", "images", "places", "contacts"}`, or `{"refused"}`.
json look_here(const MeasuredFrames& frames, const Sensor& sensor) {
  const MeasuredFile file(frames.file, sensor);
  json out = {{"size", file.size()},
              {"images", file.truth().images},
              {"places", file.truth().places},
              {"contacts", file.contacts()}};
  MeasuredFrames known = frames;
  if (known.last == 0) known.last = file.size();
  if (known.last > file.size()) return out;  // said with the place in the experiment
  std::vector<std::uint64_t> rows(known.last - known.first);
  std::iota(rows.begin(), rows.end(), known.first);
  known.truth = file.truth();
  file.read(known, sensor, rows);
  return out;
}

/// Locates the file and reads what it holds.
void look_at(JsonObject& object, const Sensor& sensor, const fs::path& folder, bool rows_given,
             MeasuredFrames& frames) {
  frames.file = object.text("file");
  if (frames.file.is_relative()) frames.file = folder / frames.file;
  frames.name = frames.file.filename().string();
  if (!fs::is_regular_file(frames.file)) {
    object.fail("file", "there is no file " + printable_path(frames.file.string()) +
                            "; a relative path begins at the experiment's folder");
  }
  const std::string checksum = hash_of_file(frames.file);
  if (object.has("checksum") && object.text("checksum") != checksum) {
    object.fail("checksum", "the file has another one, " + checksum +
                                "; leave it out, or name the file that was meant");
  }
  frames.checksum = checksum;
  json said;
  try {
    said = inspected(frames.file, [&] { return look_here(frames, sensor); });
  } catch (const InputError& wrong) {
    object.fail("file", wrong.what());
  }
  const auto size = said.at("size").get<std::uint64_t>();
  if (!rows_given) frames.last = size;
  if (frames.last > size) {
    object.fail("rows", "must be rows [first, last) of the " + std::to_string(size) +
                            " in the file, got " + std::to_string(frames.first) + " to " +
                            std::to_string(frames.last));
  }
  frames.truth = {said.at("images").get<bool>(), said.at("places").get<bool>()};
  frames.contacts = said.at("contacts").get<std::uint64_t>();
}

/// `rows`: that are divided.
void visit(Fields& fields, FoldPart& fold, std::uint64_t rows) {
  fields.integer("count", fold.count, 2, 1000);
  if (fields.reading() && static_cast<std::uint64_t>(fold.count) > rows) {
    fields.fail("count", "must be at most the number of rows, " + std::to_string(rows));
  }
  fields.required().integer("number", fold.number, 0, fields.describing() ? 999 : fold.count - 1);
  fields.required().choice("part", fold.held_out, {{"held-out", true}, {"rest", false}});
  fields.integer("seed", fold.seed, 0, 2147483647);
  if (fold.held_out && !fields.describing()) return;
  if (fields.reading()) {
    const auto count = static_cast<std::uint64_t>(fold.count);
    const auto number = static_cast<std::uint64_t>(fold.number);
    fold.to = rows - (rows * (number + 1) / count - rows * number / count);
  }
  fields.derived().rows("slice", fold.from, fold.to, fields.reading() ? fold.to : 1000000000);
}

void visit_contact(Fields& fields, MeasuredFrames& frames, double unit, double radius) {
  fields.derived().number("radius_mm", frames.radius_mm, {1e-6 * unit, radius * unit, false, "mm"});
  fields.number("conductivity_ratio", frames.conductivity_ratio,
                {conductivity_ratios[0], conductivity_ratios[1]});
  if (fields.writing() && frames.strength_of.empty()) return;
  fields.object("strength", [&](Fields& strength) {
    strength.required().text("dataset", frames.strength_of);
    strength.required().number("full", frames.full_strength, Range::positive());
  });
}

/// Declared fields; the others come from the file. `unit` and `radius` are of the sheet.
void visit(Fields& fields, MeasuredFrames& frames, double unit, double radius) {
  fields.derived().rows("rows", frames.first, frames.last, 1000000000);
  fields.number("scale", frames.scale, {1e-12, 1e12, false, "V"});
  fields.object("contact", [&](Fields& contact) { visit_contact(contact, frames, unit, radius); });
}

/// The findings of an earlier inspection, for a recipe that is read without the file.
void visit_found(Fields& fields, MeasuredFrames& frames) {
  fields.required().text("file", frames.name);
  fields.required().text("checksum", frames.checksum);
  fields.required().object("holds", [&](Fields& holds) {
    holds.boolean("images", frames.truth.images);
    holds.boolean("places", frames.truth.places);
    holds.required().integer("contacts", frames.contacts, 1, 1000);
  });
}

}  // namespace

std::vector<std::uint64_t> MeasuredFrames::rows() const {
  std::vector<std::uint64_t> all(last - first);
  std::iota(all.begin(), all.end(), first);
  if (!fold) return all;
  RandomStream random(fold->seed, key_of("folds"), 0, Purpose::scene);
  for (std::size_t i = all.size(); i > 1; --i) {  // Fisher-Yates
    std::swap(all[i - 1],
              all[static_cast<std::size_t>(random.integer(0, static_cast<int>(i) - 1))]);
  }
  const auto at = [&](int number) {
    return all.begin() + static_cast<std::ptrdiff_t>(all.size() * static_cast<std::size_t>(number) /
                                                     static_cast<std::size_t>(fold->count));
  };
  const auto begin = at(fold->number);
  const auto end = at(fold->number + 1);
  if (fold->held_out) return {begin, end};
  // The other folds start after this one, so that their first rows differ between folds.
  std::vector<std::uint64_t> rest(end, all.end());
  rest.insert(rest.end(), all.begin(), begin);
  return {rest.begin() + static_cast<std::ptrdiff_t>(fold->from),
          rest.begin() + static_cast<std::ptrdiff_t>(fold->to)};
}

MeasuredFrames measured_frames_from_json(JsonObject& object, const Sensor& sensor,
                                         const std::optional<fs::path>& folder) {
  MeasuredFrames frames;
  const bool rows_given = object.has("rows") && !object.raw("rows").is_null();
  const double unit = sensor.sheet->unit_mm();
  frames.radius_mm = default_radius * sensor.sheet->inner_radius() * unit;
  Fields::read_some(object, [&](Fields& fields) {
    visit(fields, frames, unit, sensor.sheet->radius());
    if (!folder) visit_found(fields, frames);
  });
  if (folder) look_at(object, sensor, *folder, rows_given, frames);
  Fields::read_some(object, [&](Fields& fields) {
    fields.object("fold", frames.fold, [&](Fields& fold, FoldPart& part) {
      visit(fold, part, frames.last - frames.first);
    });
  });
  return frames;
}

void add_to(json& out, const MeasuredFrames& measured) {
  MeasuredFrames frames = measured;
  out.update(Fields::written([&](Fields& fields) {
    visit(fields, frames, 0, 0);
    visit_found(fields, frames);
    fields.object("fold", frames.fold, [](Fields& fold, FoldPart& part) { visit(fold, part, 0); });
  }));
}

nlohmann::ordered_json measured_schema() {
  MeasuredFrames frames;
  nlohmann::ordered_json schema = Fields::schema([&](Fields& fields) {
    visit(fields, frames, 0, INFINITY);
    fields.object("fold", frames.fold, [](Fields& fold, FoldPart& part) { visit(fold, part, 0); });
  });
  schema["required"] = {"file"};
  return schema;
}

}  // namespace ertbench
