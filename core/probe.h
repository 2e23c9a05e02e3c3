#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// Numbers by which the behaviour of one part of the program is recognised: what it makes of a
/// small fixed input. Another build gives the same numbers, up to rounding, unless it computes
/// something else.
///
/// The numbers come in parts of `projections`, one part for each array. They are the array's
/// products with fixed random vectors, so that a sign, a transposition, another order and any
/// single value show.
struct Probe {
  static constexpr std::size_t projections = 8;

  std::vector<double> numbers;
  /// Largest difference of two numbers, relative to the norm of their part, that rounding explains.
  double tolerance = rounding;

  /// FMA and other kernels change the last digit, the 16th or, of images that are made in float32,
  /// the 8th. Factorisations and the few iterations of a probe amplify that.
  static constexpr double rounding = 1e-5;
  /// An iteration that stops at a relative duality gap of 1e-4 leaves this much open.
  static constexpr double stopped_early = 1e-3;
  /// Networks compute in float32, whose last digit (6e-8) grows in the dozen steps of Adam of a
  /// probe: a weight whose gradient is rounding noise takes its step in either direction.
  static constexpr double trained = 2e-3;

  /// Adds the part of an array. The numbers keep nine digits.
  void add(const Eigen::Ref<const Eigen::VectorXd>& values);
  template <typename Derived>
  void add_matrix(const Eigen::MatrixBase<Derived>& values) {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = values;
    add(Eigen::Map<const Eigen::VectorXd>(rows.data(), rows.size()));
  }
};

/// By their names: "data/grid", "solver/tsvd", "scores", "limit".
using Probes = std::map<std::string, Probe>;

/// By how much of its norm `made` is off, the largest of all parts; infinite where the probes have
/// not as many numbers or one of them is not finite.
double difference(const Probe& made, const Probe& now);

/// Which of the probes in `now` differ in `made`, "the probe solver/tsvd differs by 0.31 of its
/// norm"; empty where all agree within the tolerances of `now`. No probes in `made` at all stand
/// for those of release 0.2.0 (release_probes); where "front" alone is missing, it stands for that
/// of frames without loose and half-dead electrodes, and is kept there too.
std::string probe_difference(const Probes& made, const Probes& now);

/// `{"solver/tsvd": [numbers]}`.
nlohmann::json to_json(const Probes& probes);
/// Throws nlohmann::json::exception where it is none.
Probes probes_from_json(const nlohmann::json& probes);

/// The probes of release 0.2.0, whose files do not carry them: core/release_probes.json.
const Probes& release_probes();

/// The probe of this program: from memory, else from its file in the cache (cache_folder()/probes,
/// by the hash of the program), else computed and kept there. A file that cannot be read counts as
/// none, and one that cannot be written is done without. Not thread-safe.
Probe cached_probe(const std::string& name, const std::function<Probe()>& compute);
/// True if cached_probe would not compute it.
bool has_cached_probe(const std::string& name);

}  // namespace ertbench
