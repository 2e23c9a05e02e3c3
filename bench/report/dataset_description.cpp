#include "bench/report/dataset_description.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/json_text.h"

namespace ertbench {
namespace {

std::string range_text(const std::pair<double, double>& interval) {
  char text[64];
  if (interval.first == interval.second) {
    std::snprintf(text, sizeof text, "%g", interval.first);
  } else {
    std::snprintf(text, sizeof text, "%g to %g", interval.first, interval.second);
  }
  return text;
}

std::string added_noise_text(const Noise& noise) {
  char snr[64];
  std::snprintf(snr, sizeof snr, "%g dB SNR (%s basis)", *noise.snr_db, name_of(noise.basis));
  return snr;
}

std::string measured_description(const DatasetSpec& spec) {
  const MeasuredFrames& frames = *spec.measured();
  std::string text = std::to_string(spec.count) + " frames of " + frames.name + " (checksum " +
                     frames.checksum + "), rows " + std::to_string(frames.first) + " to " +
                     std::to_string(frames.last - 1);
  if (const auto& fold = frames.fold) {
    text += ", of fold " + std::to_string(fold->number + 1) + " of " + std::to_string(fold->count) +
            (fold->held_out ? " the part held out" : " the rest");
  }
  if (!frames.truth.places) text += "; where contacts are is not known";
  if (!frames.truth.images) text += "; true images are not known";
  if (spec.noise.snr_db) text += "; noise that trainings add, " + added_noise_text(spec.noise);
  return text;
}

}  // namespace

std::string description(const DatasetSpec& spec) {
  if (spec.measured()) return measured_description(spec);
  std::string text = std::to_string(spec.count) + " scenes, ";
  if (const auto* d = std::get_if<SceneDistribution>(&spec.scenes)) {
    std::string shapes;
    for (const DrawnShape shape : d->shapes) {
      shapes += (shapes.empty() ? "" : ", ") + std::string(name_of(shape));
    }
    text += range_text(d->contacts) + " contact(s) each (" + shapes + "), radius " +
            range_text(d->radius) + " (sheet " + spec.sensor.sheet->extent() + "), conductivity " +
            range_text(d->conductivity_ratio) + " of the background, placed " +
            (d->inside ? "inside the sheet" : "with their centres inside the sheet");
  } else {
    text += "listed in the experiment";
  }
  if (const auto* grid = std::get_if<GridSheet>(&spec.model)) {
    text += "; voltages from a " + std::to_string(grid->side) + " x " + std::to_string(grid->side) +
            " grid" + (grid->side == spec.sensor.image_grid ? ", that of the images" : "") + "; ";
  } else {
    char fraction[64];
    std::snprintf(fraction, sizeof fraction, "%g",
                  std::get<ContinuousSheet>(spec.model).model_error);
    text += std::string("; voltages of the continuous sheet to ") + fraction + " of the noise; ";
  }
  if (spec.noise.snr_db) {
    text += added_noise_text(spec.noise);
  } else {
    text += "no noise";
  }
  if (spec.faults.any()) text += "; faults " + json_text(to_json(spec.faults));
  return text + "; seed " + std::to_string(spec.seed);
}

}  // namespace ertbench
