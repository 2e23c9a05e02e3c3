#include "forward/data/faults.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/fields.h"
#include "core/json.h"

namespace ertbench {

void add_noise(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
               RandomStream& random, Eigen::Ref<Eigen::VectorXd> frame) {
  if (!noise.snr_db) return;
  Eigen::VectorXd direction(frame.size());
  for (double& value : direction) value = random.normal();
  if (noise.spread > 0) {
    for (double& value : direction) value *= std::exp(noise.spread * random.normal());
  }
  frame += direction * (noise_norm(noise, reference, frame) / direction.norm());
}

double noise_norm(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
                  const Eigen::Ref<const Eigen::VectorXd>& frame) {
  constexpr double without_noise_db = 80;
  if (!noise.snr_db) return frame.norm() * std::pow(10.0, -without_noise_db / 20);
  const double signal =
      noise.basis == SnrBasis::absolute ? frame.norm() : (frame - reference).norm();
  return signal * std::pow(10.0, -*noise.snr_db / 20);
}

const char* name_of(SnrBasis basis) {
  return basis == SnrBasis::absolute ? "absolute" : "difference";
}

namespace {

using Eigen::VectorXd;

double root_mean_square(const Eigen::Ref<const VectorXd>& voltages) {
  return voltages.norm() / std::sqrt(static_cast<double>(voltages.size()));
}

/// The electronics of one frame, drawn whole, so that no fault shifts another's numbers.
struct Draw {
  std::vector<int> electrodes;  ///< in the order in which they die
  VectorXd gain;                ///< [measuring pairs] in [-1, 1]
  VectorXd offset;              ///< [measuring pairs] in [-1, 1]
  VectorXd floating;            ///< [channels] standard normal
  double hum_phase;             ///< rad
  double hum_frequency;         ///< rad a channel

  Draw(const Sensor& sensor, RandomStream& random)
      : electrodes(static_cast<std::size_t>(sensor.electrode_count)),
        gain(sensor.measurements()),
        offset(sensor.measurements()),
        floating(sensor.channels()) {
    std::iota(electrodes.begin(), electrodes.end(), 0);
    const int last = sensor.electrode_count - 1;
    for (int i = 0; i < last; ++i) {
      std::swap(electrodes[static_cast<std::size_t>(i)],
                electrodes[static_cast<std::size_t>(random.integer(i, last))]);
    }
    for (double& value : gain) value = random.uniform(-1, 1);
    for (double& value : offset) value = random.uniform(-1, 1);
    for (double& value : floating) value = random.normal();
    hum_phase = random.uniform(0, 2 * std::numbers::pi);
    hum_frequency = random.uniform(0, std::numbers::pi);
  }
};

double dead_reading(DeadReading reading, double voltage, double rms, double normal) {
  switch (reading) {
    case DeadReading::floating:
      return rms * normal;
    case DeadReading::half:
      return voltage / 2;
    case DeadReading::intermittent:
      return normal > 0 ? voltage : 0;
    default:
      return 0;
  }
}

/// Leaves `share` of the change of the channel before in each channel's change.
void settle(double share, const VectorXd& reference, Eigen::Ref<VectorXd> frame) {
  if (share == 0) return;
  const VectorXd change = frame - reference;
  const Eigen::Index rest = change.size() - 1;
  frame.tail(rest) += share * (change.head(rest) - change.tail(rest));
}

/// Rounds to the converter's steps; what exceeds its range stays at its end.
void convert(int bits, const VectorXd& reference, Eigen::Ref<VectorXd> voltages) {
  if (bits == 0) return;
  const double full_scale = 1.25 * reference.cwiseAbs().maxCoeff();
  const double step = 2 * full_scale / std::pow(2.0, bits);
  for (double& voltage : voltages) {
    voltage = std::clamp(step * std::round(voltage / step), -full_scale, full_scale);
  }
}

/// `spacing`: between electrodes, domain units.
void visit(Fields& fields, Faults& f, int electrodes, double spacing) {
  fields.integer("dead_electrodes", f.dead_electrodes, 0, std::max(0, electrodes - 5));
  fields.choice("dead_reading", f.dead_reading,
                {{"zero", DeadReading::zero},
                 {"floating", DeadReading::floating},
                 {"half", DeadReading::half},
                 {"intermittent", DeadReading::intermittent}});
  fields.number("gain_error", f.gain_error, {0, 10});
  fields.number("offset", f.offset, {0, 10});
  fields.number("hum", f.hum, {0, 10});
  fields.number("settling", f.settling, {0, 0.99});
  fields.integer("adc_bits", f.adc_bits, 0, 24);
  if (fields.reading() && f.adc_bits == 1) {
    fields.fail("adc_bits", "must be 0 for no converter, or 2 to 24");
  }
  fields.number("electrode_displacement", f.electrode_displacement, {0, spacing / 3});
  fields.choice(
      "displacement_reference", f.displacement_reference,
      {{"retaken", DisplacementReference::retaken}, {"stale", DisplacementReference::stale}});
  fields.number("battery_sag", f.battery_sag, {-0.99, 0.99});
  fields.number("battery_noise", f.battery_noise, {0, 1});
  fields.boolean("current_measured", f.current_measured);
  fields.number("background_drift", f.background_drift, {-0.99, 0.99});
  fields.number("reference_age_s", f.reference_age_s, {0, 1e7, false, "s"});
  fields.number("background_change", f.background_change, {-0.99, 0.99});
  fields.number("background_gradient", f.background_gradient, {0, 0.99});
  fields.number("background_mottle", f.background_mottle, {0, 0.5});
  fields.number("electrode_width", f.electrode_width, {0, 0.9 * spacing});
  fields.number("impedance_drift", f.impedance_drift, {0, 0.99});
}

nlohmann::json all_keys(Faults faults) {
  return Fields::written([&](Fields& fields) { visit(fields, faults, 0, 0); });
}

}  // namespace

void apply_faults(const Faults& faults, const Sensor& sensor,
                  const Eigen::Ref<const VectorXd>& reference, RandomStream& random,
                  Eigen::Ref<VectorXd> frame) {
  if (!faults.of_electronics()) return;
  const Draw draw(sensor, random);
  const double offset = faults.offset * root_mean_square(reference);
  const double hum = faults.hum * root_mean_square(reference) * std::numbers::sqrt2;
  const double floating = root_mean_square(frame);
  std::vector<bool> dead(draw.electrodes.size(), false);
  for (int n = 0; n < faults.dead_electrodes; ++n) {
    dead[static_cast<std::size_t>(draw.electrodes[static_cast<std::size_t>(n)])] = true;
  }
  const auto is_dead = [&](const ElectrodePair& pair) {
    return dead[static_cast<std::size_t>(pair.first)] ||
           dead[static_cast<std::size_t>(pair.second)];
  };
  const std::vector<ElectrodePair> drives = drive_pairs(sensor);
  const std::vector<ElectrodePair> measurements = measurement_pairs(sensor);
  const std::vector<Channel> channels = channels_of(sensor);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    const int pair = channels[c].measurement;
    frame[i] = frame[i] * (1 + faults.gain_error * draw.gain[pair]) + offset * draw.offset[pair] +
               hum * std::sin(draw.hum_phase + draw.hum_frequency * static_cast<double>(i));
    if (!is_dead(drives[static_cast<std::size_t>(channels[c].drive)]) &&
        !is_dead(measurements[static_cast<std::size_t>(pair)])) {
      continue;
    }
    frame[i] = dead_reading(faults.dead_reading, frame[i], floating, draw.floating[i]);
  }
  settle(faults.settling, reference, frame);
  convert(faults.adc_bits, reference, frame);
}

double battery_factor(const Faults& faults, double since_reference_s, RandomStream& random) {
  if (!faults.of_battery()) return 1;
  const double current = (1 - faults.battery_sag * since_reference_s / 3600) *
                         (1 + faults.battery_noise * random.normal());
  if (!faults.current_measured) return current;
  // Read by the frame's converter, whose range begins above the nominal current as above the
  // largest voltage.
  const double step = faults.adc_bits > 0 ? 2.5 / std::pow(2.0, faults.adc_bits) : 0;
  const double read = step > 0 ? step * std::round(current / step) : current;
  return current / std::max(read, 1e-6);
}

double drift_factor(const Faults& faults, double since_reference_s) {
  // A sheet that loses all it has keeps a little, as a voltage is finite.
  return std::max(0.01, 1 + faults.background_drift * since_reference_s / 60);
}

VectorXd recorded_reference(const Faults& faults, const VectorXd& reference) {
  VectorXd recorded = reference;
  convert(faults.adc_bits, reference, recorded);
  return recorded;
}

VectorXd displacements(const Faults& faults, const Sensor& sensor, RandomStream& random) {
  VectorXd shift(sensor.electrode_count);
  for (double& value : shift) value = faults.electrode_displacement * random.uniform(-1, 1);
  return shift;
}

Sensor with_faulty_electrodes(const Faults& faults, const Sensor& sensor) {
  constexpr double usual_width = 0.05;        // domain units
  constexpr double drifting_impedance = 0.2;  // of a width of the sheet's resistance
  Sensor out = sensor;
  if (faults.electrode_width > 0) {
    out.electrode_width = faults.electrode_width;
    if (out.electrode_model == ElectrodeModel::point) out.electrode_model = ElectrodeModel::gap;
  }
  if (faults.impedance_drift == 0) return out;
  if (out.electrode_width == 0) out.electrode_width = usual_width;
  if (out.electrode_model != ElectrodeModel::complete) {
    out.electrode_model = ElectrodeModel::complete;
    out.contact_impedance = drifting_impedance * out.electrode_width *
                            (sensor.sheet->unit_mm() / 1000) / sensor.background;
  }
  return out;
}

VectorXd impedance_factors(const Faults& faults, const Sensor& sensor, RandomStream& random) {
  VectorXd factors(sensor.electrode_count);
  for (double& factor : factors) factor = 1 + faults.impedance_drift * random.uniform(-1, 1);
  return factors;
}

Eigen::Vector2d gradient_of(const Faults& faults, const Sheet& sheet, RandomStream& random) {
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  return faults.background_gradient / sheet.radius() *
         Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

VectorXd gradient_factors(const Faults& faults, const Sheet& sheet, const PixelGrid& pixels,
                          RandomStream& random) {
  const Eigen::Vector2d slope = gradient_of(faults, sheet, random);
  const Eigen::Vector2d middle = sheet.bounds().center();
  const Eigen::ArrayXd x = pixels.centres_x().transpose().array() - middle.x();
  const Eigen::ArrayXd y = pixels.centres_y().transpose().array() - middle.y();
  VectorXd factors(pixels.count());
  for (int row = 0; row < pixels.rows(); ++row) {
    factors.segment(pixels.columns() * row, pixels.columns()) =
        1 + slope.x() * x + slope.y() * y[row];
  }
  return factors;
}

VectorXd mottle_factors(const Faults& faults, const Sheet& sheet, const PixelGrid& pixels,
                        RandomStream& random) {
  constexpr int waves = 64;
  constexpr double least = 0.1;
  const double length = sheet.radius() / 4;
  const VectorXd x = pixels.centres_x().transpose();
  const VectorXd y = pixels.centres_y().transpose();
  VectorXd field = VectorXd::Zero(pixels.count());
  for (int wave = 0; wave < waves; ++wave) {  // of a field with a Gaussian correlation
    const Eigen::Vector2d k = Eigen::Vector2d(random.normal(), random.normal()) / length;
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    for (int row = 0; row < pixels.rows(); ++row) {
      field.segment(pixels.columns() * row, pixels.columns()).array() +=
          (k.x() * x.array() + k.y() * y[row] + phase).cos();
    }
  }
  return (1 + faults.background_mottle * std::sqrt(2.0 / waves) * field.array()).max(least);
}

Faults faults_from_json(JsonObject object, const Sensor& sensor, const SheetModel& model) {
  const bool continuous = std::holds_alternative<ContinuousSheet>(model);
  Faults faults;
  Fields::read(object, [&](Fields& fields) {
    visit(fields, faults, sensor.electrode_count, sensor.electrode_spacing());
  });
  if (faults.of_electrodes() && !continuous) {
    object.fail(faults.electrode_displacement > 0 ? "electrode_displacement"
                : faults.electrode_width > 0      ? "electrode_width"
                                                  : "impedance_drift",
                R"(needs "grid": "auto"; on a grid electrodes sit on its nodes)");
  }
  if (faults.background_mottle > 0 && continuous) {
    object.fail("background_mottle", R"(needs a "grid" that is a number, such as 96; "auto" )"
                                     "knows even sheets alone");
  }
  return faults;
}

nlohmann::json to_json(const Faults& faults) {
  const nlohmann::json none = all_keys(Faults{});
  const nlohmann::json all = all_keys(faults);
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [key, value] : all.items()) {
    if (!value.is_string() && value != none.at(key)) out[key] = value;
  }
  // The kind of a fault is part of a recipe where there is such a fault.
  if (faults.dead_electrodes > 0) out["dead_reading"] = all.at("dead_reading");
  if (faults.of_electrodes() || faults.background_mottle > 0) {
    out["displacement_reference"] = all.at("displacement_reference");
  }
  return out;
}

nlohmann::ordered_json faults_schema() {
  Faults faults;  // of any sensor: 5 to 64 electrodes, 8 domain units of border at most
  return Fields::schema([&](Fields& fields) { visit(fields, faults, 64, 8.0 / 5); });
}

}  // namespace ertbench
