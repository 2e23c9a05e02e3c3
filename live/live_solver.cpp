#include "live/live_solver.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/seconds.h"
#include "forward/border/border_model.h"
#include "frames/reference_check.h"

namespace ertbench {
namespace {

std::vector<PressStep> steps_of(const TouchRegions& regions,
                                const std::vector<KnownTouch>& touches) {
  std::vector<PressStep> out;
  for (const KnownTouch& touch : touches) {
    const std::optional<int> area = regions.area(touch.reading);
    if (!area || !touch.reading.sum) continue;
    PressStep step;
    step.area = *area;
    step.force_N = touch.force_N;
    step.sum = std::abs(*touch.reading.sum);
    out.push_back(step);
  }
  return out;
}

bool is_whole(const FoundContact& contact) {
  return contact.place.allFinite() && std::isfinite(contact.strength) &&
         std::isfinite(contact.peak) && std::isfinite(contact.area);
}

}  // namespace

ForceReader::ForceReader(const TouchRegions& regions, const std::vector<KnownTouch>& touches)
    : regions_(regions),
      calibration_(steps_of(regions, touches), Strength::sum, regions.region_of()) {}

std::optional<double> ForceReader::force_N(const FrameReading& reading) const {
  if (reading.contacts.empty() || !reading.sum) return std::nullopt;
  const std::optional<int> area = regions_.area(reading);
  const int region = regions_.region_of()[static_cast<std::size_t>(*area)];
  return calibration_.force_N(region, std::abs(*reading.sum));
}

CollisionSignal::CollisionSignal(const TouchRegions& regions,
                                 const std::vector<FrameReading>& quiet, const FrameRuns& runs,
                                 double false_alarms_per_hour)
    : regions_(regions) {
  std::vector<double> per_hour = regions.shares();
  for (double& one : per_hour) one *= false_alarms_per_hour;
  thresholds_ = values_of(fit_thresholds(regions.signal(quiet), runs, per_hour, "live"));
}

bool CollisionSignal::alarm(const FrameReading& reading) const {
  return alarms_of(regions_.signal({&reading, 1}), thresholds_)[0] != 0;
}

LiveSolver::LiveSolver(const Sensor& sensor, std::shared_ptr<const Solver> solver,
                       const ContactRule& rule)
    : sensor_(sensor),
      solver_(std::move(solver)),
      bounds_(sensor),
      twins_(twin_symmetries(sensor)),
      rule_(rule),
      reader_(sensor),
      regions_(std::make_unique<TouchRegions>(sensor)),
      change_(1, sensor.channels()),
      found_(1) {
  answer_.image.resize(1, sensor.pixels());
  begin_sequence();
}

void LiveSolver::set_reference(const Eigen::RowVectorXd& voltages) {
  reference_ = voltages;
  expect();
}

void LiveSolver::expect() {
  expected_ = mended(Frames(reference_));
  expected_ = filled_reference(sensor_, expected_.row(0).transpose(),
                               BorderModel(sensor_).reference_voltages())
                  .transpose();
}

void LiveSolver::use(std::shared_ptr<const Solver> solver) {
  solver_ = std::move(solver);
  begin_sequence();
}

void LiveSolver::mend(const ReferenceVerdict& verdict) {
  from_ = verdict.from;
  factor_ = verdict.factor;
  expect();
}

Frames LiveSolver::mended(FramesView changes) const {
  if (from_.empty()) return changes;
  Frames out = changes(Eigen::all, from_);
  out.array().rowwise() *= factor_.transpose().array();
  return out;
}

void LiveSolver::begin_sequence() { stream_ = solver_->open_stream(); }

void LiveSolver::image() {
  FrameReport& report = answer_.report;
  report = {};
  found_[0].clear();
  bool has_places = true;
  stream_->reconstruct(change_, answer_.image, {&report, 1});
  if (!answer_.image.allFinite()) report.status = FrameStatus::undefined;
  if (report.status == FrameStatus::undefined) {
    answer_.image.setConstant(std::numeric_limits<double>::quiet_NaN());
  } else if (const std::vector<FoundContact>* contacts = stream_->contacts()) {
    std::copy_if(contacts->begin(), contacts->end(), std::back_inserter(found_[0]), is_whole);
  } else if (const ContactFinder* finder = solver_->contact_finder()) {
    finder->find_contacts(change_, found_);
    std::erase_if(found_[0], [](const FoundContact& one) { return !is_whole(one); });
  } else {
    has_places = false;  // the image shows them all
    reader_.read(rule_, answer_.image.row(0), found_[0]);
  }
  if (has_places) add_twins(sensor_, twins_, found_[0]);
  answer_.reading = report.status == FrameStatus::undefined
                        ? FrameReading{}
                        : frame_reading(sensor_, answer_.image.row(0), found_[0]);
}

void LiveSolver::learn_forces(FramesView changes, const std::vector<double>& forces_N) {
  std::vector<KnownTouch> touches;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    begin_sequence();  // each is a touch of its own
    change_ = mended(changes.middleRows(f, 1));
    image();
    touches.push_back({answer_.reading, forces_N[static_cast<std::size_t>(f)]});
  }
  forces_ = std::make_unique<ForceReader>(*regions_, touches);
  begin_sequence();
}

void LiveSolver::learn_quiet(FramesView changes, const FrameRuns& runs,
                             double false_alarms_per_hour) {
  std::vector<FrameReading> readings;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const auto number = static_cast<std::size_t>(f);
    if (std::binary_search(runs.first.begin(), runs.first.end(), number)) begin_sequence();
    change_ = mended(changes.middleRows(f, 1));
    image();
    readings.push_back(answer_.reading);
  }
  collision_ = std::make_unique<CollisionSignal>(*regions_, readings, runs, false_alarms_per_hour);
  begin_sequence();
}

const LiveAnswer& LiveSolver::answer(const Eigen::Ref<const Eigen::RowVectorXd>& voltages,
                                     double time_s) {
  const SteadyClock::time_point start = SteadyClock::now();
  change_ = voltages;
  if (!from_.empty()) change_ = mended(change_);
  change_ -= expected_;
  if (quiet_) quiet_->follow(change_.row(0), time_s);
  image();
  report(bounds_.judge(change_.row(0), expected_.row(0), answer_.report), answer_.report);
  answer_.solver_s = seconds_since(start);
  answer_.tracks = tracker_.update(time_s, centred_places_mm(found_[0], *sensor_.sheet));
  answer_.force_N = forces_ ? forces_->force_N(answer_.reading) : std::nullopt;
  answer_.alarm = collision_ ? std::optional(collision_->alarm(answer_.reading)) : std::nullopt;
  return answer_;
}

}  // namespace ertbench
