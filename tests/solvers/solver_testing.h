#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/random.h"
#include "forward/data/dataset_file.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/scene_model.h"
#include "forward/fem/forward_model.h"
#include "solvers/registry/registry.h"

namespace ertbench::testing {

/// Standard normal numbers.
inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  RandomStream random(seed, 0, 0, Purpose::scene);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

inline std::unique_ptr<Solver> make_solver(const nlohmann::json& spec) {
  SolverRegistry registry;
#ifdef ERTBENCH_TEST_PLUGIN
  registry.load_plugin(ERTBENCH_TEST_PLUGIN);
#endif
  return registry.make(JsonObject(spec, "spec.json", ""));
}

inline std::unique_ptr<Solver> fitted(const nlohmann::json& spec, const Sensor& sensor = {}) {
  std::unique_ptr<Solver> solver = make_solver(spec);
  FitInput input;
  input.sensor = sensor;
  solver->fit(input);
  return solver;
}

struct Reconstruction {
  Images images;
  std::vector<FrameReport> reports;
};

inline Reconstruction reconstruct(const Solver& solver, const Frames& changes,
                                  const Sensor& sensor = {}) {
  Reconstruction out{Images(changes.rows(), sensor.pixels()),
                     std::vector<FrameReport>(static_cast<std::size_t>(changes.rows()))};
  solver.reconstruct(changes, out.images, out.reports);
  return out;
}

inline Hdf5File eidors() { return Hdf5File::open(ERTBENCH_TEST_DATA "/eidors_d2s.h5"); }

/// The changes that EIDORS computed for its six scenes, without noise.
inline Frames eidors_changes() {
  const Hdf5File file = eidors();
  Frames changes = file.read_rows("/scenes/voltages", 0, 6);
  changes.rowwise() -= file.read_vector("/reference_voltages").transpose();
  return changes;
}

inline double relative_difference(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                  const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return (a - b).norm() / b.norm();
}

/// Random contacts with 50 dB noise.
inline DatasetSpec random_contacts(std::uint64_t count, const Sensor& sensor = {},
                                   double blank_fraction = 0) {
  const nlohmann::json spec = {{"count", count},
                               {"seed", 11},
                               {"grid", sensor.image_grid},
                               {"snr_db", 50},
                               {"snr_basis", "absolute"},
                               {"scenes", {{"blank_fraction", blank_fraction}}}};
  return dataset_spec_from_json(JsonObject(spec, "test", ""), sensor, "validation");
}

inline Frames random_changes(std::uint64_t count, const Sensor& sensor = {}) {
  const SceneModel model(sensor, GridSheet{sensor.image_grid});
  Frames changes = generate_block(random_contacts(count, sensor), model, 0, count).voltages;
  changes.rowwise() -= model.reference_voltages().transpose();
  return changes;
}

/// What `call` says when it throws `Error`; empty where it does not.
template <typename Error, typename Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace ertbench::testing
