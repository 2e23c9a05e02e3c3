#include "frames/calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/errors.h"
#include "core/fields.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/random.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/data/sheet_model.h"
#include "frames/frame_bounds.h"
#include "frames/reference_check.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr Eigen::Index least_frames = 10;
constexpr double far_from_others = 5;  ///< relative to the middle frame's distance
constexpr double rounding = 1e-6;      ///< of a file's numbers, relative
constexpr std::size_t most_listed = 8;
constexpr double much_drift = 0.05;
constexpr double touched_spread = 0.01;  ///< of frames around their median, that contacts explain
constexpr double touched_share = 0.75;
constexpr double floating_noise = 10;  ///< a floating channel's noise over the median channel's

double decibels(double signal, double noise) {
  // Frames that are all alike get a value that no instrument reaches.
  constexpr double most = 300;
  return noise > 0 ? std::min(most, 20 * std::log10(signal / noise)) : most;
}

/// Change of each channel from the first frame to the last along its fitted line, [channels].
Eigen::RowVectorXd lines_of(const Frames& frames) {
  const Eigen::Index count = frames.rows();
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(count, -0.5, 0.5);
  return time.transpose() * frames / time.squaredNorm();
}

double change_of_a_contact(const Sensor& sensor, const BorderModel& model) {
  Contact disc;
  disc.centre = sensor.sheet->bounds().center();
  disc.half_size.setConstant(Calibration::contact_radius * sensor.sheet->inner_radius());
  disc.conductivity_ratio = Calibration::contact_ratio;
  return model.solve_at({{disc}}, 1).change.norm();
}

double reciprocity_error_of(const Sensor& sensor, const Eigen::VectorXd& reference) {
  double differences = 0;
  double means = 0;
  for (const auto& [a, b] : reciprocal_pairs(sensor)) {
    differences += std::pow(reference[a] - reference[b], 2);
    if (a != b) means += std::pow((reference[a] + reference[b]) / 2, 2);
  }
  return means > 0 ? std::sqrt(differences / means) : 0;
}

/// Frames that are flagged or far from the median, and a sentence about them.
QuietCheck frames_unlike(const Sensor& sensor, const Frames& frames, std::uint64_t from) {
  QuietCheck out;
  const Eigen::RowVectorXd usual = median_of_rows(frames);
  const FrameBounds bounds(sensor);
  std::vector<double> far;
  for (const auto& frame : frames.rowwise()) far.push_back((frame - usual).norm());
  const double limit = std::max(far_from_others * median(far), rounding * usual.norm());
  std::string list;
  for (Eigen::Index f = 0; f < frames.rows(); ++f) {
    const FrameVerdict verdict = bounds.judge(frames.row(f) - usual, usual);
    const bool fault = verdict.faults != 0 && !verdict.even;  // a drift is another matter
    if (!fault && far[static_cast<std::size_t>(f)] <= limit) continue;
    out.unlike.push_back(f);
    if (out.unlike.size() > most_listed) continue;
    list += (list.empty() ? "" : ", ") + std::to_string(from + static_cast<std::uint64_t>(f)) +
            (verdict.faults != 0 ? " (" + verdict.text() + ")" : "");
  }
  if (out.unlike.empty()) {
    // Where half of them are touched or more, the median is of no frame.
    Frames spread = frames.rowwise() - usual;
    spread -= Frames(spread * usual.transpose() * usual / usual.squaredNorm());  // a drift's level
    const Eigen::VectorXd sizes = spread.rowwise().norm() / usual.norm();
    const double size = median(std::vector<double>(sizes.begin(), sizes.end()));
    if (size > touched_spread && ContactSpan(sensor).share(spread) > touched_share) {
      out.refused = "frames differ from each other by " + fixed(100 * size, 1) +
                    " % as contacts make them differ: they are touched";
    }
    return out;
  }
  out.refused = "frames are unlike the others, touched or of another unit: " + list +
                (out.unlike.size() > most_listed ? ", ..." : "") + " of " +
                std::to_string(frames.rows()) + ", counted from 0 in what is read";
  return out;
}

/// Above what any instrument reaches and below what any number can be.
constexpr double most_volts = 1e9;
constexpr double most_decibels = 1000;

/// All but the sensors.
void visit(Fields& fields, Calibration& c) {
  const auto by_channel = [&](const char* key, Eigen::VectorXd& values, double least) {
    if (fields.reading()) values.resize(c.sensor.channels());
    fields.required().numbers(key, {values.data(), static_cast<std::size_t>(values.size())},
                              {least, most_volts});
  };
  fields.required().integer("frames", c.frames, 1, 2000000000);
  by_channel("reference_voltages", c.reference, -most_volts);
  by_channel("noise_V", c.noise, 0);
  by_channel("white_noise_V", c.white_noise, 0);
  fields.required().object("snr_db", [&](Fields& snr) {
    constexpr Range range{-most_decibels, most_decibels};
    snr.required().number("absolute", c.snr_absolute, range);
    snr.required().number("absolute_white", c.snr_white, range);
    snr.required().number("difference", c.snr_difference, range);
    JsonValue contact = json{{"radius", Calibration::contact_radius},
                             {"conductivity_ratio", Calibration::contact_ratio}};
    snr.required().any("contact", contact);
  });
  fields.required().object("drift", [&](Fields& drift) {
    drift.required().number("level", c.drift_level, {});
    drift.required().number("relative", c.drift, {});
  });
  fields.required().integers("dead_electrodes", c.dead_electrodes, 0,
                             static_cast<std::size_t>(c.sensor.electrode_count),
                             {0, c.sensor.electrode_count - 1});
  fields.required().number("reciprocity_error", c.reciprocity_error, Range::at_least(0));
  fields.required().number("level", c.level, {});
  fields.required().number("background", c.background, {1e-9, 1e8, false, "S/m"});
  fields.required().number("misfit", c.misfit, Range::at_least(0));
}

constexpr std::uint64_t scenes = 400;
constexpr const char* set_name = "calibrated";

}  // namespace

Calibration calibrate(const Sensor& sensor, const Frames& frames) {
  const Eigen::Index count = frames.rows();
  if (count < least_frames || frames.cols() != sensor.channels()) {
    throw std::invalid_argument("calibrate: ten frames of the sensor's channels, at least");
  }
  Calibration out;
  out.sensor = out.declared = sensor;
  out.frames = static_cast<int>(count);
  const Eigen::RowVectorXd mean = frames.colwise().mean();
  out.reference = median_of_rows(frames).transpose();
  const Frames rest = frames.rowwise() - mean;
  const auto freedom = static_cast<double>(count - 1);
  out.noise = (rest.colwise().squaredNorm() / freedom).cwiseSqrt().transpose();
  const Frames steps = frames.bottomRows(count - 1) - frames.topRows(count - 1);
  out.white_noise = (steps.colwise().squaredNorm() / (2 * freedom)).cwiseSqrt().transpose();

  const Eigen::RowVectorXd lines = lines_of(frames);
  out.drift = mean.norm() > 0 ? lines.norm() / mean.norm() : 0;
  out.drift_level = mean.norm() > 0 ? lines.dot(mean) / mean.squaredNorm() : 0;
  out.reciprocity_error = reciprocity_error_of(sensor, out.reference);

  const BorderModel model(sensor);
  const Eigen::VectorXd& expected = model.reference_voltages();
  const Eigen::VectorXd filled = filled_reference(sensor, out.reference, expected);
  Eigen::VectorXd live = (filled.array() == out.reference.array()).select(expected, 0.0);
  double level = out.reference.dot(live) / live.squaredNorm();
  out.level = level;
  out.background = sensor.background / level;
  // Voltages go with the inverse of the background but for contact impedances, which stay.
  if (sensor.electrode_model == ElectrodeModel::complete && level > 0) {
    Sensor fitted = sensor;
    for (int step = 0; step < 50 && std::abs(level - 1) > 1e-9; ++step) {
      fitted.background = out.background;
      live = (live.array() != 0).select(BorderModel(fitted).reference_voltages(), 0.0);
      level = out.reference.dot(live) / live.squaredNorm();
      out.background /= level;
    }
  }
  out.misfit =
      out.reference.norm() > 0 ? (out.reference - level * live).norm() / out.reference.norm() : 1;
  out.snr_absolute = decibels(out.reference.norm(), out.noise.norm());
  out.snr_white = decibels(out.reference.norm(), out.white_noise.norm());
  out.snr_difference =
      decibels(std::abs(out.level) * change_of_a_contact(sensor, model), out.noise.norm());

  std::vector<int> zero = electrodes_reading_zero(sensor, out.reference, out.level * expected);
  const double usual = median(std::vector<double>(out.noise.begin(), out.noise.end()));
  const std::vector<int> floating = electrodes_with_bad_channels(
      sensor, [&](Eigen::Index c) { return out.noise[c] > floating_noise * usual && usual > 0; });
  zero.insert(zero.end(), floating.begin(), floating.end());
  std::ranges::sort(zero);
  zero.erase(std::unique(zero.begin(), zero.end()), zero.end());
  out.dead_electrodes = std::move(zero);
  return out;
}

QuietCheck check_quiet(const Sensor& sensor, const Frames& frames) {
  Eigen::Index repeated = 0;
  for (Eigen::Index f = 1; f < frames.rows(); ++f) repeated += frames.row(f) == frames.row(f - 1);
  if (2 * repeated < frames.rows()) return frames_unlike(sensor, frames, 0);
  return {{},
          "half of the frames or more repeat the one before, so that they know no noise; "
          "record them anew"};
}

void require_quiet(const Sensor& sensor, const Frames& frames, const std::string& source,
                   std::uint64_t from) {
  if (frames.rows() < 3) return;  // nobody can say which is unlike the other
  Frames present = frames;
  for (Eigen::Index c = 0; c < present.cols(); ++c) {
    if (present.col(c).array().isNaN().all()) present.col(c).setZero();  // a missing channel
  }
  const std::string refused = frames_unlike(sensor, present, from).refused;
  if (!refused.empty()) {
    throw InputError(source + ": " + refused + "; name frames without contact alone");
  }
}

std::vector<std::string> warnings_of(const Calibration& calibration) {
  std::vector<std::string> out;
  if (std::abs(calibration.drift_level) > much_drift || calibration.drift > much_drift) {
    out.push_back("the voltages drift by " + fixed(100 * calibration.drift, 1) +
                  " % from the first frame to the last; record once they are steady");
  }
  std::vector<int> constant;
  for (Eigen::Index c = 0; c < calibration.noise.size(); ++c) {
    if (calibration.noise[c] == 0) constant.push_back(static_cast<int>(c));
  }
  if (!constant.empty()) {
    out.push_back(text_of_channels(calibration.sensor, constant) + ": dead, no frame changes it");
  }
  return out;
}

json to_json(const Calibration& calibration) {
  Calibration c = calibration;
  json out = Fields::written([&](Fields& fields) { visit(fields, c); });
  out["schema"] = Calibration::schema;
  out["sensor"] = to_json(c.sensor);
  if (!(c.declared == c.sensor)) out["declared_sensor"] = to_json(c.declared);
  return out;
}

Calibration read_calibration(const std::filesystem::path& file) {
  const json content = read_json_file(file);
  JsonObject object(content, file.string(), "");
  if (!object.has("noise_V") || !object.has("schema")) {
    object.fail("", "is no calibration; `ertbench calibrate` writes one");
  }
  object.integer("schema", Calibration::schema, Calibration::schema);
  Calibration c;
  c.sensor = sensor_from_json(object.object("sensor"));
  c.declared = c.sensor;
  if (object.has("declared_sensor")) {
    c.declared = sensor_from_json(object.object("declared_sensor"));
  }
  Fields::read_some(object, [&](Fields& fields) { visit(fields, c); });
  if (object.has("source")) object.raw("source");
  object.finish();
  return c;
}

void require_calibration_of(const Calibration& calibration, const Sensor& sensor,
                            const std::filesystem::path& file) {
  Sensor same = sensor;
  same.background = calibration.sensor.background;
  if (!(same == calibration.sensor)) {
    throw InputError(file.string() + ": /sensor: is another than that of the frames; calibrate " +
                     "again with their --sensor");
  }
}

Calibration on_channels_of(const Calibration& calibration, const Sensor& sensor,
                           const std::filesystem::path& file) {
  Calibration out = calibration;
  const std::vector<ChannelElectrodes> wanted = electrodes_of_channels(sensor);
  if (electrodes_of_channels(out.sensor) == wanted ||
      out.sensor.electrode_count != sensor.electrode_count) {
    require_calibration_of(out, sensor, file);
    return out;
  }
  out.sensor = with_channels(out.sensor, wanted);
  require_calibration_of(out, with_channels(sensor, wanted), file);
  std::map<ChannelElectrodes, Eigen::Index> index;
  for (const ChannelElectrodes& one : electrodes_of_channels(calibration.sensor)) {
    index.try_emplace(one, std::ssize(index));
  }
  for (Eigen::VectorXd Calibration::*part :
       {&Calibration::reference, &Calibration::noise, &Calibration::white_noise}) {
    Eigen::VectorXd& values = out.*part;
    values.setConstant(std::ssize(wanted), std::nan(""));
    for (Eigen::Index c = 0; c < values.size(); ++c) {
      const auto found = index.find(wanted[static_cast<std::size_t>(c)]);
      if (found != index.end()) values[c] = (calibration.*part)[found->second];
    }
  }
  return out;
}

DatasetSpec calibrated_spec(const Calibration& calibration, const Sensor& sensor,
                            const std::string& name) {
  const nlohmann::json json = {{"count", scenes},         {"seed", 1},
                               {"grid", "auto"},          {"snr_db", calibration.snr_absolute},
                               {"snr_basis", "absolute"}, {"scenes", {{"contacts", {0, 3}}}}};
  Sensor fitted = sensor;
  fitted.background = calibration.background;
  return dataset_spec_from_json(JsonObject(json, "calibration", ""), fitted, name);
}

void write_calibrated_set(const Calibration& calibration, const Sensor& sensor,
                          const std::filesystem::path& file, int threads) {
  const DatasetSpec spec = calibrated_spec(calibration, sensor, set_name);
  generate_dataset(spec, file, {threads, {}});
  Frames voltages = DatasetFile(file).clean_voltages(0, spec.count);
  for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
    RandomStream random = spec.noise_stream(static_cast<std::uint64_t>(f));
    for (Eigen::Index c = 0; c < voltages.cols(); ++c) {
      voltages(f, c) += calibration.noise[c] * random.normal();
    }
  }
  Hdf5File out = Hdf5File::open_writable(file);
  out.write_rows(dataset_layout::voltages, 0, voltages);
  out.write_checksum();
  out.close();
}

void complete_contacts(nlohmann::json& entry, const Sensor& sensor,
                       const Eigen::VectorXd& reference, double relative_noise) {
  const auto is_open = [&](const char* key) {
    return entry.value(key, nlohmann::json("auto")) == "auto";
  };
  if (entry.value("type", "") != "contacts") return;
  if (is_open("prior_weight")) entry["prior_weight"] = 1;
  if (!is_open("noise") || !(relative_noise > 0)) return;
  const Eigen::VectorXd model = uniform_reference(sensor);
  entry["noise"] = relative_noise * model.norm() / std::sqrt(static_cast<double>(model.size()));
  const Eigen::VectorXd at_level = reference.dot(model) / model.squaredNorm() * model;
  const double misfit = (reference - at_level).norm() / reference.norm();
  if (!(misfit > 0.01)) return;  // a model made it
  if (!entry.contains("model_error")) entry["model_error"] = std::clamp(misfit, 0.02, 0.1);
  if (!entry.contains("nuisances")) {
    entry["nuisances"] = {{"level", 0.1}, {"gradient", 0.05}, {"electrodes", 0.01}};
  }
}

}  // namespace ertbench
