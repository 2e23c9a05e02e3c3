#include "solvers/registry/solver_probe.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "solvers/channel_mask.h"
#include "solvers/front/front.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr double time_limit_s = 300;

DatasetSpec small_set(const std::string& name, int count, int seed) {
  // Noise strong enough that a training without it is another.
  const json set = {{"count", count},
                    {"seed", seed},
                    {"grid", 24},
                    {"snr_db", 40},
                    {"snr_basis", "absolute"},
                    {"scenes", {{"contacts", {1, 2}}, {"shapes", {"disc", "ellipse"}}}}};
  return dataset_spec_from_json(JsonObject(set, "probe", ""), Sensor{}, name);
}

/// The frames and what the solvers may learn from, written once for all settings.
class Sets {
 public:
  Sets() : training_(written("train", 64, 1)), validation_(written("validation", 32, 2)) {
    const DatasetFile test = written("test", 6, 3);
    changes_ = test.voltages(0, test.size()).rowwise() - test.reference_voltages().transpose();
  }

  const Frames& changes() const { return changes_; }
  FitInput input(const TemporaryFolder& work) const {
    FitInput out;
    out.training = &training_;
    out.validation = &validation_;
    out.work_folder = work.path();
    return out;
  }

 private:
  DatasetFile written(const std::string& name, int count, int seed) const {
    generate_dataset(small_set(name, count, seed), folder_ / (name + ".h5"));
    return DatasetFile(folder_ / (name + ".h5"));
  }

  TemporaryFolder folder_{"probe"};
  DatasetFile training_;
  DatasetFile validation_;
  Frames changes_;
};

void add_contacts(const ContactFinder& finder, const Frames& changes, Probe& probe) {
  std::vector<std::vector<FoundContact>> contacts(static_cast<std::size_t>(changes.rows()));
  finder.find_contacts(changes, contacts);
  std::vector<double> values;
  for (const std::vector<FoundContact>& frame : contacts) {
    values.push_back(static_cast<double>(frame.size()));
    for (const FoundContact& one : frame) {
      values.insert(values.end(), {one.place.x(), one.place.y(), one.strength});
    }
  }
  probe.add(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
}

void add_fit(Solver& solver, const Sets& sets, Probe& probe) {
  const TemporaryFolder work("probe_fit");
  solver.fit(sets.input(work));
  const Frames& changes = sets.changes();
  Images images(changes.rows(), Sensor{}.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(changes.rows()));
  solver.reconstruct(changes, images, reports);
  probe.add_matrix(images);
  Eigen::VectorXd said(changes.rows() + 1);
  said[0] = 1;  // a norm for frames that are all without fault
  for (Eigen::Index i = 0; i < changes.rows(); ++i) {
    const FrameReport& report = reports[static_cast<std::size_t>(i)];
    said[i + 1] = 16.0 * static_cast<double>(report.status) + report.reasons;
  }
  probe.add(said);
  if (solver.contact_finder()) add_contacts(*solver.contact_finder(), changes, probe);
}

double tolerance_of(ImageComparison comparison) {
  switch (comparison) {
    case ImageComparison::rounding:
      return Probe::rounding;
    case ImageComparison::duality_gap:
      return Probe::stopped_early;
    case ImageComparison::seeds:
      return Probe::trained;
  }
  return Probe::rounding;
}

}  // namespace

Probe computed_solver_probe(SolverRegistry& registry, const std::string& type) {
  const SolverInfo info = registry.load(type);
  Probe probe;
  probe.tolerance = tolerance_of(info.comparison);
  if (info.probes.empty()) return probe;
  const Sets sets;
  for (const std::string& text : info.probes) {
    json settings = json::parse(text);
    settings["type"] = type;
    for (const int seed : {1, 2}) {
      if (info.has_seed()) settings["seed"] = seed;
      if (seed > 1 && !info.has_seed()) break;
      add_fit(*registry.make(JsonObject(settings, "probe", "")), sets, probe);
    }
  }
  return probe;
}

namespace {

/// The frame as it is, then with what may be wrong with it; electrode 5 is the one that fails.
Frames faulty(const Eigen::RowVectorXd& change, const Eigen::RowVectorXd& reference) {
  const std::vector<ElectrodeSet> electrodes = electrode_sets_of_channels(Sensor{});
  Frames out = change.replicate(6, 1);
  out.row(1) -= 0.05 * (change + reference);
  for (Eigen::Index c = 0; c < out.cols(); ++c) {
    if (!(electrodes[static_cast<std::size_t>(c)] >> 5 & 1)) continue;
    out(2, c) = -reference[c];
    out(3, c) = -reference[c] + 0.3 * reference.maxCoeff() * std::cos(static_cast<double>(c));
    out(4, c) = (change[c] - reference[c]) / 2;
    if (c % 2 == 0) out(5, c) = -reference[c];
  }
  return out;
}

Probe computed_front_probe() {
  const TemporaryFolder folder("probe");
  generate_dataset(small_set("validation", 200, 2), folder / "validation.h5");
  const DatasetFile set(folder / "validation.h5");
  FitInput input;
  input.validation = &set;
  const FrameCheck check(input, 0);
  const Front front({}, check, {.level = 0.1, .gradient = 0.1, .electrodes = 0.02});
  const Eigen::RowVectorXd reference = set.reference_voltages().transpose();
  Probe probe;
  for (std::uint64_t f = 0; f < 3; ++f) {
    Frames frames = faulty(set.voltages(f, 1).row(0) - reference, reference);
    Eigen::MatrixXd said(frames.rows(), 6);
    Eigen::MatrixXd amplitudes(frames.rows(), 2 * (3 + Sensor{}.electrode_count));
    for (Eigen::Index i = 0; i < frames.rows(); ++i) {
      const FrameCheck::Verdict verdict = check.judge(frames.row(i).data());
      const FrameState state = front.look(frames.row(i).data());
      said.row(i) << verdict.reasons, static_cast<double>(verdict.dead),
          static_cast<double>(state.floating), static_cast<double>(state.half_dead), state.lost,
          std::log(state.noise);
      amplitudes.row(i) << state.amplitudes.transpose(), state.deviations.transpose();
      check.impute(frames.row(i).data(), verdict);
    }
    probe.add_matrix(said);
    probe.add_matrix(amplitudes);
    probe.add_matrix(frames);
  }
  return probe;
}

}  // namespace

Probe front_probe() { return cached_probe("front", computed_front_probe); }

std::optional<Probe> solver_probe(const std::string& type) {
  const std::vector<std::string> own = SolverRegistry().types();
  if (std::find(own.begin(), own.end(), type) == own.end()) return std::nullopt;
  const std::string name = "solver/" + type;
  std::optional<Probe> probe;
  try {
    probe = cached_probe(name, [&] {
      const IsolatedOutcome outcome = run_isolated(
          [&](const auto& send) {
            SolverRegistry registry;
            registry.allow_plugins();
            try {
              const Probe computed = computed_solver_probe(registry, type);
              send(json_text({{"numbers", computed.numbers}, {"tolerance", computed.tolerance}}));
            } catch (const std::exception& error) {
              send(json_text({{"failed", error.what()}}));
            }
          },
          {time_limit_s, machine_memory_bytes() / 2});
      const json said = outcome.messages.empty()
                            ? json{{"failed", outcome.end.text()}}
                            : parse_json(outcome.messages.front(), "the probe " + name);
      if (said.contains("failed")) throw InputError(said.at("failed").get<std::string>());
      return Probe{said.at("numbers"), said.at("tolerance")};
    });
  } catch (const InputError& error) {
    spdlog::warn("the probe {} cannot be computed, and cached fits are taken without it: {}", name,
                 printable(error.what()));
    return std::nullopt;
  }
  return probe->numbers.empty() ? std::nullopt : probe;
}

Probes solver_probes(const std::string& type) {
  const std::optional<Probe> probe = solver_probe(type);
  if (!probe) return {};
  return {{"solver/" + type, *probe}};
}

Probes all_solver_probes() {
  Probes out;
  for (const std::string& type : SolverRegistry().types()) out.merge(solver_probes(type));
  return out;
}

}  // namespace ertbench
