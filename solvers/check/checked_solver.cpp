#include "solvers/check/checked_solver.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/errors.h"
#include "core/json_reader.h"
#include "core/json_text.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/channel_mask.h"
#include "solvers/check/checked_file.h"

namespace ertbench {
namespace {

/// Characters of a text that a solver, which may be anybody's plugin, says of itself.
constexpr std::size_t most_said = 1000;

/// A finite number times zero is zero, any other NaN: no branch, and several numbers at a time.
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
  // From before there was one: electrodes that read zero are found without a fit.
  if (!numbers) return FrameCheck(sensor, masked);
  try {
    return FrameCheck(sensor, masked, *numbers);
  } catch (const std::invalid_argument& error) {
    throw InputError(file.string() + ": /frame_check: " + error.what() + "; fit the solver anew");
  }
}

}  // namespace

CheckedSolver::CheckedSolver(std::string type, std::unique_ptr<Solver> inner, bool check_frames)
    : type_(std::move(type)), inner_(std::move(inner)), check_frames_(check_frames) {}

std::unique_ptr<Solver> CheckedSolver::make(const std::string& type, const SolverInfo& info,
                                            JsonObject parameters) {
  const bool check_frames = parameters.boolean_or("inference_check", true);
  return std::unique_ptr<Solver>(
      new CheckedSolver(type, info.make(std::move(parameters)), check_frames));
}

std::vector<ParameterInfo> CheckedSolver::own_parameters() {
  return {{"inference_check",
           "report frames that are not to be trusted (dead electrodes, noise, out of range) as "
           "suspect; default true",
           ParameterRole::inference}};
}

nlohmann::json CheckedSolver::parameters() const {
  nlohmann::json out = printable_json(inner_->parameters(), most_said);
  out["inference_check"] = check_frames_;
  return out;
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
  for (const DatasetFile* set : {input.training, input.validation}) {
    if (set && set->sensor() != input.sensor) {
      throw InputError(set->path().string() + ": is of another sensor; generate it for this one");
    }
  }
  inner_->check(input.sensor);
  inner_->fit(input);
  become_ready(input.sensor, FrameCheck(input, inner_->masked_channels().electrodes));
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

/// Contacts of frames of which some electrodes are dead come from a sequence of one frame, which is
/// told so.
class CheckedSolver::MaskingFinder final : public ContactFinder {
 public:
  MaskingFinder(const Solver& solver, const FrameCheck& check, Eigen::Index pixels)
      : solver_(solver), check_(check), pixels_(pixels) {}

  void find_contacts(FramesView changes,
                     std::span<std::vector<FoundContact>> contacts) const override {
    Images image(1, pixels_);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      FrameReport report;
      report.dead = check_.judge(changes.row(f).data()).dead;
      const std::unique_ptr<FrameStream> alone =
          report.dead != 0 ? solver_.open_stream() : std::unique_ptr<FrameStream>();
      if (!alone || !alone->contacts()) {
        solver_.contact_finder()->find_contacts(changes.row(f),
                                                contacts.subspan(static_cast<std::size_t>(f), 1));
        continue;
      }
      alone->reconstruct(changes.row(f), image, {&report, 1});
      contacts[static_cast<std::size_t>(f)] = *alone->contacts();
    }
  }

 private:
  const Solver& solver_;
  const FrameCheck& check_;
  Eigen::Index pixels_;
};

void CheckedSolver::become_ready(const Sensor& sensor, FrameCheck check) {
  sensor_ = sensor;
  masked_ = inner_->masked_channels();
  check_ = std::move(check);
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
    finder_ = std::make_unique<MaskingFinder>(*inner_, check_, sensor.pixels());
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
  const auto verdict_of = [&](Eigen::Index f) { return check_.judge(changes.row(f).data()); };
  if (masked_.detect) {
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const FrameCheck::Verdict verdict = verdict_of(f);
      reports[static_cast<std::size_t>(f)].reasons = verdict.reasons;
      reports[static_cast<std::size_t>(f)].dead = verdict.dead;
    }
  }
  const std::optional<Frames> cleared = without_masked(changes);
  const FramesView given = cleared ? FramesView(*cleared) : changes;
  if (stream != nullptr) {
    stream->reconstruct(given, images, reports);
  } else {
    inner_->reconstruct(given, images, reports);
  }
  for (const Eigen::Index pixel : off_sheet_) images.col(pixel).setZero();
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    FrameReport& report = reports[static_cast<std::size_t>(f)];
    const FrameCheck::Verdict before = {static_cast<std::uint8_t>(report.reasons & ~unexplained),
                                        report.dead};
    report.reasons &= check_frames_ ? unexplained : 0;
    if (report.reasons != 0 && report.status == FrameStatus::ok) {
      report.status = FrameStatus::suspect;
    }
    report.dead = 0;
    if (!is_finite(changes, images, f)) report.status = FrameStatus::undefined;
    if (report.status == FrameStatus::undefined || !check_frames_) continue;
    const FrameCheck::Verdict verdict = masked_.detect ? before : verdict_of(f);
    FrameCheck::report(verdict, masked_.detect && verdict.dead != 0, report);
  }
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
  // A network may make a finite image of a frame that is not.
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
