#include "forward/data/data_probes.h"

#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/measured_file.h"
#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr const char* measured_kind = "data/measured";

/// A kind of datasets and small sets of it, `{"sensor", "set"}`.
struct Kind {
  const char* name;
  bool (*is_part_of)(const DatasetSpec& spec);
  const char* sets;  ///< a JSON list
};

const Kind kinds[] = {
    {"data/grid", [](const DatasetSpec& spec) { return spec.model.index() == 0; },
     R"([{"sensor": {}, "set": {"count": 4, "grid": 24, "scenes": {"contacts": [1, 3],
          "shapes": ["disc", "ellipse", "rectangle", "polygon"]}}},
         {"sensor": {}, "set": {"count": 3, "grid": 48, "snr_basis": "difference",
                  "rasterisation": "centre", "scenes": {"contacts": 2, "placement": "centre-inside",
                  "shapes": ["ring", "cross", "bar"]}}}])"},
    {"data/border", [](const DatasetSpec& spec) { return spec.model.index() == 1; },
     R"([{"sensor": {}, "set": {"count": 2, "grid": "auto", "scenes": {}}},
         {"sensor": {"shape": "disc", "diameter_mm": 200, "drive": "opposite",
                     "electrode_model": "complete", "electrode_width": 0.1,
                     "contact_impedance": 0.001},
          "set": {"count": 2, "grid": "auto", "scenes": {"contacts": 1}}}])"},
    {"data/touches", [](const DatasetSpec& spec) { return spec.has_touches(); },
     R"([{"sensor": {"side_mm": 200, "skin": {"patches": 24, "patch_mm": 7.5,
                     "law": {"type": "falling"}}},
          "set": {"count": 3, "grid": 24, "scenes": {"touches": [1, 2], "force_N": [1, 10],
                 
                  "indenters": [{"type": "flat", "radius_mm": 11}, {"type": "finger"},
                                {"type": "sphere", "radius_mm": 18}]}}},
         {"sensor": {"side_mm": 200, "skin": {"patches": 24, "patch_mm": 7.5,
                     "law": {"type": "rising"}}},
          "set": {"count": 2, "grid": 24, "scenes": {"touches": 1, "force_N": 5,
                  "indenters": [{"type": "finger"}]}}}])"},
    {"data/sequences", [](const DatasetSpec& spec) { return spec.sequences() != nullptr; },
     R"([{"sensor": {"side_mm": 200, "skin": {"patches": 24, "patch_mm": 7.5,
                     "law": {"type": "falling"}}},
          "set": {"grid": 24, "scenes": {"sequence": "collide", "sequences": 1,
                  "duration_s": 0.08, "onset_s": [0.02, 0.03], "frame_rate": 125}}},
         {"sensor": {"side_mm": 200, "skin": {"patches": 24, "patch_mm": 7.5,
                     "law": {"type": "rising"}}},
          "set": {"grid": 24, "scenes": {"sequence": "write", "characters": "A",
                  "frame_rate": 5, "drive_time_ms": 10}}}])"},
    {"data/faults", [](const DatasetSpec& spec) { return spec.faults.any(); },
     R"([{"sensor": {}, "set": {"count": 2, "grid": 24, "scenes": {}, "faults": {
          "dead_electrodes": 1, "dead_reading": "floating", "gain_error": 0.05, "offset": 0.01,
          "adc_bits": 12, "battery_sag": 0.01, "battery_noise": 0.001, "background_drift": 0.01,
          "background_gradient": 0.1, "reference_age_s": 60}}},
         {"sensor": {}, "set": {"count": 2, "grid": "auto", "scenes": {}, "faults": {
          "electrode_displacement": 0.01, "background_change": 0.02}}}])"}};

/// Values where there are any, 0 where an absent contact has NaN.
RowMajorMatrix without_nan(const RowMajorMatrix& rows) {
  return rows.array().isNaN().select(0.0, rows);
}

void add_block(const DatasetBlock& block, const Eigen::VectorXd& reference, double background,
               Probe& probe) {
  probe.add(reference);
  probe.add_matrix(block.voltages.rowwise() - reference.transpose());
  probe.add_matrix((block.conductivity.array() - background).matrix());
  probe.add_matrix(without_nan(block.contacts));
  if (block.forces.cols() > 0) probe.add_matrix(without_nan(block.forces));
  if (block.moments.cols() > 0) probe.add_matrix(block.moments);
}

Probe generated(const Kind& kind) {
  Probe probe;
  for (const json& one : json::parse(kind.sets)) {
    const Sensor sensor = sensor_from_json(JsonObject(one.at("sensor"), kind.name, ""));
    json set = {{"snr_db", 40}, {"snr_basis", "absolute"}};
    set.update(one.at("set"));
    const DatasetSpec spec =
        dataset_spec_from_json(JsonObject(set, kind.name, ""), sensor, "probe");
    const SceneModel model(sensor, spec.model);
    add_block(generate_block(spec, model, 0, std::min<std::uint64_t>(spec.count, 8)),
              model.reference_voltages(), sensor.background, probe);
  }
  return probe;
}

/// Two frames of a file with places in millimetres.
Probe measured() {
  const Sensor sensor;
  const TemporaryFolder folder("probe");
  const std::filesystem::path file = folder / "measured.h5";
  Eigen::VectorXd reference(sensor.channels());
  for (Eigen::Index i = 0; i < reference.size(); ++i) {
    reference[i] = 0.1 + 0.05 * std::cos(static_cast<double>(i));
  }
  Frames frames(2, reference.size());
  for (Eigen::Index i = 0; i < reference.size(); ++i) {
    frames(0, i) = reference[i] * (1 + 0.01 * std::sin(static_cast<double>(i)));
    frames(1, i) = reference[i] * (1 - 0.02 * std::sin(static_cast<double>(3 * i)));
  }
  RowMajorMatrix places(2, 2);
  places << 20, -30, -45, 10;
  Hdf5File out = Hdf5File::create(file);
  const auto write = [&](const std::string& name, const RowMajorMatrix& rows) {
    out.create_dataset(name, {2, static_cast<std::uint64_t>(rows.cols())});
    out.write_rows(name, 0, rows);
  };
  write("/voltages", frames);
  write("/positions_mm", places);
  out.write_vector("/reference_voltages", reference);
  out.close();
  const json set = {{"file", file.string()},
                    {"rows", {0, 2}},
                    {"contact", {{"radius_mm", 20}, {"conductivity_ratio", 0.5}}}};
  const DatasetSpec spec =
      dataset_spec_from_json(JsonObject(set, measured_kind, ""), sensor, "probe", folder.path());
  const MeasuredBlocks blocks(spec);
  Probe probe;
  add_block(blocks.block(0, 2), blocks.reference_voltages(), sensor.background, probe);
  return probe;
}

Probe measured_probe() { return cached_probe(measured_kind, measured); }

Probe probe_of(const Kind& kind) {
  return cached_probe(kind.name, [&] { return generated(kind); });
}

}  // namespace

Probes data_probes(const DatasetSpec& spec) {
  if (spec.measured()) return {{measured_kind, measured_probe()}};
  Probes out;
  for (const Kind& kind : kinds) {
    if (kind.is_part_of(spec)) out[kind.name] = probe_of(kind);
  }
  return out;
}

Probes all_data_probes() {
  Probes out = {{measured_kind, measured_probe()}};
  for (const Kind& kind : kinds) out[kind.name] = probe_of(kind);
  return out;
}

}  // namespace ertbench
