#include "solvers/check/checked_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/channel_mask.h"
#include "solvers/check/stored_solver.h"

namespace ertbench {
namespace {

/// Longest text, in characters, that is taken from a solver, which may be any plugin.
constexpr std::size_t most_said = 1000;

/// A finite number times zero is zero, any other is NaN: vectorises without branches.
template <typename Row>
bool all_finite(const Row& row) {
  return (row.array() * 0.0).sum() == 0;
}

std::span<FrameReport> part_of(std::span<FrameReport> reports, Eigen::Index first,
                               Eigen::Index count) {
  return reports.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
}

FrameCheck check_from(const std::optional<Eigen::VectorXd>& numbers, const Sensor& sensor,
                      ElectrodeSet masked, const std::filesystem::path& file) {
  // A file without a frame check: electrodes that read zero are detected without a fit.
  if (!numbers) return FrameCheck(sensor, masked);
  try {
    return FrameCheck(sensor, masked, *numbers);
  } catch (const std::invalid_argument& error) {
    throw InputError(file.string() + ": /frame_check: " + error.what() + "; fit the solver anew");
  }
}

}  // namespace

CheckedSolver::CheckedSolver(std::string type, JsonObject& own)
    : type_(std::move(type)),
      entry_(own.value()),
      check_frames_(own.boolean_or("inference_check", true)),
      imputes_(own.boolean_or("inference_imputation", true)),
      sets_limits_(own.choice_or("inference_limits", "stored", {"stored", "validation"}) !=
                   "stored"),
      nuisances_(Nuisances::from_json(own, "inference_nuisances")) {
  if (sets_limits_ && !own.has("checkpoint")) {
    own.fail("inference_limits", "a fit sets limits anyway; remove it, or add \"checkpoint\"");
  }
  if (!own.has("checkpoint")) return;
  const std::string word = own.text("checkpoint");
  try {
    stored_ = fitted_file(word, own.folder());
  } catch (const InputError& error) {
    own.fail("checkpoint", error.what());
  }
}

std::unique_ptr<Solver> CheckedSolver::make(const std::string& type, const SolverInfo& info,
                                            JsonObject parameters) {
  std::unique_ptr<CheckedSolver> solver(new CheckedSolver(type, parameters));
  solver->inner_ = info.make(std::move(parameters));
  return solver;
}

std::vector<ParameterInfo> CheckedSolver::own_parameters() {
  return {
      {"inference_check",
       "report frames that are not to be trusted (dead electrodes, noise, out of range) as "
       "suspect; default true",
       ParameterRole::inference},
      {"inference_imputation",
       "replace the channels of dead electrodes by their mean given the live ones, for solvers "
       "that do not mask them themselves; needs inference_check; default true",
       ParameterRole::inference},
      {"inference_limits",
       "of the check for a solver with a checkpoint: \"stored\" with it (the default), or set on "
       "the \"validation\" set; those of a network with training faults and \"front\" are set on "
       "frames with these faults",
       ParameterRole::inference},
      {"inference_nuisances",
       "{\"level\", \"gradient\", \"electrodes\"}, standard deviations of what the whole sheet "
       "does besides being touched: level and gradient are estimated beside them and taken out "
       "of each frame, as far as the frame check was fitted; default none",
       ParameterRole::inference},
      {"checkpoint",
       "the file of a fitted solver, relative to this one, or a name that `ertbench list "
       "--fitted` shows; it is loaded in place of a fit",
       ParameterRole::file}};
}

nlohmann::json CheckedSolver::parameters() const {
  nlohmann::json out = printable_json(inner_->parameters(), most_said);
  out["inference_check"] = check_frames_;
  if (!imputes_) out["inference_imputation"] = false;
  if (sets_limits_) out["inference_limits"] = "validation";
  nuisances_.add_to(out, "inference_nuisances");
  if (!stored_.empty()) out["checkpoint"] = printable_json(entry_->at("checkpoint"), most_said);
  return out;
}

void CheckedSolver::check(const Sensor& sensor) const {
  if (stored_.empty()) return inner_->check(sensor);
  const CheckedFile of_this_sensor(stored_, {type_, sensor});
}

void CheckedSolver::require_stored_parameters() const {
  const nlohmann::json stored = inner_->parameters();
  for (const auto& [name, value] : entry_->items()) {
    const bool free = value == "auto" || name.starts_with("inference_");
    if (free || !stored.contains(name) || stored.at(name) == value) continue;
    throw InputError(stored_.string() + ": was fitted with \"" + printable(name) +
                     "\": " + json_shown(stored.at(name)) + ", not with " + json_shown(value) +
                     "; remove it beside \"checkpoint\"");
  }
}

FitReport CheckedSolver::fit_report() const {
  FitReport report = inner_->fit_report();
  report.status = printable(report.status);
  report.message = printable(report.message, most_said);
  if (ready_ && check_frames_ && !check_.has_limits()) {
    report.frame_check = "electrodes that read zero alone";
  }
  return report;
}

void CheckedSolver::fit(const FitInput& input) {
  ready_ = false;
  if (!stored_.empty()) {
    load(stored_, input.sensor);
    require_stored_parameters();
    if (!sets_limits_) return;
    if (!input.validation) {
      throw InputError(type_ + ": \"inference_limits\": needs the dataset \"validation\"; add it");
    }
    return become_ready(input.sensor, fitted_check(input));
  }
  for (const DatasetFile* set : {input.training, input.validation}) {
    if (set && set->sensor() != input.sensor) {
      throw InputError(set->path().string() + ": is of another sensor; generate it for this one");
    }
  }
  inner_->check(input.sensor);
  inner_->fit(input);
  become_ready(input.sensor, fitted_check(input));
}

FrameCheck CheckedSolver::fitted_check(const FitInput& input) const {
  FrameCheck out(input, inner_->masked_channels().electrodes);
  const auto* const told = inner_as<ToldSolver>();
  if (told && told->is_told()) out.widen(told->usual_frames(input));
  return out;
}

void CheckedSolver::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) const {
  reconstruct_with(nullptr, changes, images, reports);
}

class CheckedSolver::Stream final : public FrameStream {
 public:
  explicit Stream(const CheckedSolver& solver)
      : solver_(solver), inner_(solver.inner_->open_stream()) {}

  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport> reports) override {
    solver_.reconstruct_with(inner_.get(), changes, images, reports);
  }
  const std::vector<FoundContact>* contacts() const override {
    return inner_ ? inner_->contacts() : nullptr;
  }

 private:
  const CheckedSolver& solver_;
  std::unique_ptr<FrameStream> inner_;
};

/// Detects contacts in frames with dead electrodes through a stream of one frame, whose report
/// holds the dead electrodes.
class CheckedSolver::MaskingFinder final : public ContactFinder {
 public:
  MaskingFinder(const Solver& solver, const FrameCheck& check, bool imputes, Eigen::Index pixels)
      : solver_(solver), check_(check), imputes_(imputes), pixels_(pixels) {}

  void find_contacts(FramesView changes,
                     std::span<std::vector<FoundContact>> contacts) const override {
    Images image(1, pixels_);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      FrameReport report;
      const FrameCheck::Verdict verdict = check_.judge(changes.row(f).data());
      report.dead = imputes_ ? verdict.lost() : verdict.dead;
      Frames change = changes.row(f);
      if (imputes_ && verdict.torn) check_.impute(change.data(), verdict);
      const std::unique_ptr<FrameStream> alone =
          report.dead != 0 ? solver_.open_stream() : std::unique_ptr<FrameStream>();
      if (!alone || !alone->contacts()) {
        solver_.contact_finder()->find_contacts(change,
                                                contacts.subspan(static_cast<std::size_t>(f), 1));
        continue;
      }
      alone->reconstruct(change, image, {&report, 1});
      contacts[static_cast<std::size_t>(f)] = *alone->contacts();
    }
  }

 private:
  const Solver& solver_;
  const FrameCheck& check_;
  bool imputes_;
  Eigen::Index pixels_;
};

void CheckedSolver::become_ready(const Sensor& sensor, FrameCheck check) {
  sensor_ = sensor;
  masked_ = inner_->masked_channels();
  const auto* const told = inner_as<ToldSolver>();
  told_ = told && told->is_told();
  check_ = std::move(check);
  front_.reset();
  if (nuisances_.any() && check_.has_limits()) front_.emplace(sensor, check_, nuisances_);
  off_sheet_.clear();
  const PixelGrid pixels = sensor.image();
  for (int p = 0; p < pixels.count(); ++p) {
    if (!pixels.on_sheet(p)) off_sheet_.push_back(p);
  }
  taken_.clear();
  if (masked_.electrodes != 0) {
    const std::vector<std::array<int, 2>> pairs = reciprocal_pairs(sensor);
    for (const Eigen::Index pair : pairs_without(sensor, masked_.electrodes)) {
      for (const int channel : pairs[static_cast<std::size_t>(pair)]) taken_.push_back(channel);
    }
  }
  finder_.reset();
  if (masked_.detect && inner_->contact_finder()) {
    finder_ = std::make_unique<MaskingFinder>(*inner_, check_, imputes_, sensor.pixels());
  }
  ready_ = true;
}

const ContactFinder* CheckedSolver::contact_finder() const {
  return finder_ ? finder_.get() : inner_->contact_finder();
}

std::unique_ptr<FrameStream> CheckedSolver::open_stream() const {
  if (!ready_) throw std::logic_error("open_stream: the solver is neither fitted nor loaded");
  return std::make_unique<Stream>(*this);
}

void CheckedSolver::reconstruct_with(FrameStream* stream, FramesView changes, ImagesView images,
                                     std::span<FrameReport> reports) const {
  if (!ready_) throw std::logic_error("reconstruct: the solver is neither fitted nor loaded");
  const Eigen::Index frames = changes.rows();
  if (changes.cols() != sensor_.channels() || images.cols() != sensor_.pixels() ||
      images.rows() != frames || reports.size() != static_cast<std::size_t>(frames)) {
    throw std::logic_error("reconstruct: frames, images and reports do not fit together");
  }
  const Eigen::Index block = inner_->block_frames() > 0 ? inner_->block_frames() : frames;
  if (frames <= block) {
    reconstruct_block(stream, changes, images, reports);
    return;
  }
  for (Eigen::Index first = 0; first < frames; first += block) {
    const Eigen::Index count = std::min(block, frames - first);
    reconstruct_block(stream, changes.middleRows(first, count), images.middleRows(first, count),
                      part_of(reports, first, count));
  }
}

void CheckedSolver::reconstruct_block(FrameStream* stream, FramesView changes, ImagesView images,
                                      std::span<FrameReport> reports) const {
  // A frame is judged without allocation after a thread's first one.
  static thread_local std::vector<FrameCheck::Verdict> kept;
  std::vector<FrameCheck::Verdict> verdicts = std::move(kept);
  verdicts.assign(reports.size(), {});
  for (std::size_t f = 0; (check_frames_ || masked_.detect) && f < reports.size(); ++f) {
    verdicts[f] = check_.judge(changes.row(static_cast<Eigen::Index>(f)).data());
    if (!masked_.detect) continue;
    reports[f].reasons = verdicts[f].reasons;
    reports[f].dead = imputes_ ? verdicts[f].lost() : verdicts[f].dead;
  }
  const std::optional<Frames> cleared = without_masked(changes);
  const FramesView whole = cleared ? FramesView(*cleared) : changes;
  const std::optional<Frames> prepared = this->prepared(whole, verdicts);
  const FramesView given = prepared ? FramesView(*prepared) : whole;
  if (stream != nullptr) {
    stream->reconstruct(given, images, reports);
  } else {
    inner_->reconstruct(given, images, reports);
  }
  for (const Eigen::Index pixel : off_sheet_) images.col(pixel).setZero();
  for (std::size_t f = 0; f < reports.size(); ++f) {
    FrameReport& report = reports[f];
    report.reasons &= check_frames_ ? unexplained : 0;
    if (report.reasons != 0 && report.status == FrameStatus::ok) {
      report.status = FrameStatus::suspect;
    }
    report.dead = 0;
    if (!is_finite(changes, images, static_cast<Eigen::Index>(f))) {
      report.status = FrameStatus::undefined;
    }
    if (report.status == FrameStatus::undefined || !check_frames_) continue;
    const bool copes = verdicts[f].dead != 0 || (imputes_ && verdicts[f].torn);
    FrameCheck::report(verdicts[f], masked_.detect && copes, report);
  }
  kept = std::move(verdicts);
}

std::optional<Frames> CheckedSolver::prepared(
    FramesView changes, const std::vector<FrameCheck::Verdict>& verdicts) const {
  std::optional<Frames> out;
  if (front_) out = changes;
  for (std::size_t f = 0; f < verdicts.size(); ++f) {
    const auto row = static_cast<Eigen::Index>(f);
    if (front_)
      front_->remove_nuisances(front_->look(changes.row(row).data()), out->row(row).data());
    const bool leaves_out = masked_.detect && !told_ && !verdicts[f].torn;
    if (!imputes_ || !verdicts[f].has_gaps() || leaves_out) continue;
    if (!out) out = changes;
    check_.impute(out->row(row).data(), verdicts[f]);
  }
  return out;
}

std::optional<Frames> CheckedSolver::without_masked(FramesView changes) const {
  if (masked_.electrodes == 0) return std::nullopt;
  bool finite = true;
  for (Eigen::Index f = 0; finite && f < changes.rows(); ++f) finite = all_finite(changes.row(f));
  if (finite) return std::nullopt;
  Frames out = Frames::Zero(changes.rows(), changes.cols());
  for (const Eigen::Index channel : taken_) out.col(channel) = changes.col(channel);
  return out;
}

bool CheckedSolver::is_finite(const FramesView& changes, const ImagesView& images,
                              Eigen::Index frame) const {
  // A network may map a frame that is not finite to a finite image.
  if (!all_finite(images.row(frame))) return false;
  if (masked_.electrodes == 0) return all_finite(changes.row(frame));
  return std::all_of(taken_.begin(), taken_.end(),
                     [&](Eigen::Index channel) { return std::isfinite(changes(frame, channel)); });
}

void CheckedSolver::save(const std::filesystem::path& file) const {
  if (!ready_) throw std::logic_error("a solver was saved before it was fitted");
  inner_->save(file);
  add_frame_check(file, {type_, sensor_}, check_.packed());
}

void CheckedSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  ready_ = false;
  const CheckedFile opened(file, {type_, sensor});
  inner_->load(opened.of_solver(), sensor);
  const ElectrodeSet masked = inner_->masked_channels().electrodes;
  become_ready(sensor, check_from(opened.frame_check(), sensor, masked, file));
}

}  // namespace ertbench
