#include "bench/check/tolerance.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/moments.h"
#include "core/student_t.h"

namespace ertbench {
namespace {

constexpr double rounding = 1e-10;
constexpr double linear_images = 1e-8;
constexpr double confidence = 0.999;

constexpr ToleranceClass classes[] = {ToleranceClass::exact, ToleranceClass::linear,
                                      ToleranceClass::interior_point, ToleranceClass::seeds};

/// A gap leaves the image within about sqrt(gap) of the optimum, as the objective grows with the
/// square of the distance; within a third of that where it was measured (pdipm). The means over the
/// frames of the quick experiment differ by up to 2e-4 between gaps of 1e-4 and 1e-8, and by 4e-13
/// between builds with and without FMA and AVX: a tenth of sqrt(gap), 1e-3 for the default, has
/// room for test sets of few frames.
double of_duality_gap(const ResultRow& row) {
  const double gap = row.parameters->value("tolerance", 1e-4);
  return 0.1 * std::sqrt(gap);
}

/// The most that a contact more or less in one frame does to that frame's value: one, as a number
/// or a share; a quarter of the sheet's side as a distance, which is OSPA's cut-off.
double one_contact(const BaselineMean& before) {
  const bool length = entry_of(before.metric).quantity == Quantity::millimetres;
  return length ? before.sensor.sheet->size_mm().maxCoeff() / 4 : 1;
}

/// What one pixel that changes sides of a threshold is worth in the mean over the frames.
double one_pixel(const BaselineMean& before) {
  const double frames = std::max(1, before.frames);
  const double pixels = before.sensor.image().count_on_sheet();
  switch (entry_of(before.metric).threshold) {
    case Threshold::none:
      return 0;
    case Threshold::area:
      return 100 / (std::sqrt(pixels) * frames);
    case Threshold::centroid: {
      const double share = 1 - before.resolution.value_or(100) / 100;  // (C2)
      const double bright_pixels = 1 + pixels * share * share;
      const double diagonal = 2 * before.sensor.sheet->radius();
      return diagonal / (2 * bright_pixels * frames);
    }
    case Threshold::contact:
      return one_contact(before) / frames;
  }
  return 0;
}

}  // namespace

const char* name_of(ToleranceClass type) {
  switch (type) {
    case ToleranceClass::exact:
      return "exact";
    case ToleranceClass::linear:
      return "linear";
    case ToleranceClass::interior_point:
      return "interior point";
    case ToleranceClass::seeds:
      return "seeds";
  }
  return "";
}

std::vector<std::string> tolerance_class_names() {
  std::vector<std::string> names;
  for (const ToleranceClass type : classes) names.emplace_back(name_of(type));
  return names;
}

ToleranceClass tolerance_class_from_name(const std::string& name) {
  for (const ToleranceClass type : classes) {
    if (name == name_of(type)) return type;
  }
  throw std::invalid_argument("no class of tolerances is called \"" + name + "\"");
}

Tolerance tolerance_of(const ResultRow& row, std::optional<ImageComparison> images) {
  if (!images) return {ToleranceClass::exact, rounding};
  switch (*images) {
    case ImageComparison::seeds:
      return {ToleranceClass::seeds, stored_image_tolerance};
    case ImageComparison::duality_gap:
      return {ToleranceClass::interior_point, of_duality_gap(row)};
    default:
      return {ToleranceClass::linear, linear_images};
  }
}

double centre_of(std::span<const double> values) { return mean(values); }

double allowed_change(const Tolerance& tolerance, const BaselineMean& before, int seeds_now) {
  const double centre = std::abs(centre_of(before.values));
  if (tolerance.type == ToleranceClass::seeds && before.values.size() > 1) {
    const auto n = static_cast<int>(before.values.size());
    const double deviation = std::max(sample_deviation(before.values), tolerance.relative * centre);
    const double t = student_t_quantile(0.5 + confidence / 2, n - 1);
    const bool counts = entry_of(before.metric).threshold == Threshold::contact;
    return t * deviation * std::sqrt(1.0 / std::max(1, seeds_now) + 1.0 / n) +
           (counts ? one_pixel(before) : 0);
  }
  const double pixel = tolerance.type == ToleranceClass::exact ? 0 : one_pixel(before);
  return std::max(tolerance.relative * centre, std::min(tolerance.relative, linear_images) *
                                                   size_of(entry_of(before.metric).quantity)) +
         pixel;
}

}  // namespace ertbench
