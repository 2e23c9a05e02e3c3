#include "bench/live/live_solver.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/seconds.h"

namespace ertbench {
namespace {

bool is_whole(const FoundContact& contact) {
  return contact.place.allFinite() && std::isfinite(contact.strength) &&
         std::isfinite(contact.peak) && std::isfinite(contact.area);
}

}  // namespace

LiveSolver::LiveSolver(const Sensor& sensor, std::shared_ptr<const Solver> solver,
                       const ContactRule& rule)
    : sensor_(sensor),
      solver_(std::move(solver)),
      rule_(rule),
      reader_(sensor),
      regions_(std::make_unique<TouchRegions>(sensor)),
      change_(1, sensor.channels()),
      found_(1) {
  answer_.image.resize(1, sensor.pixels());
  begin_sequence();
}

void LiveSolver::begin_sequence() { stream_ = solver_->open_stream(); }

void LiveSolver::image() {
  FrameReport& report = answer_.report;
  report = {};
  found_[0].clear();
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
    reader_.read(rule_, answer_.image.row(0), found_[0]);
  }
  answer_.reading = report.status == FrameStatus::undefined
                        ? FrameReading{}
                        : frame_reading(sensor_, answer_.image.row(0), found_[0]);
}

void LiveSolver::learn_forces(FramesView changes, const std::vector<double>& forces_N) {
  std::vector<KnownTouch> touches;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    begin_sequence();  // each is a touch of its own
    change_ = changes.row(f);
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
    change_ = changes.row(f);
    image();
    readings.push_back(answer_.reading);
  }
  collision_ = std::make_unique<CollisionSignal>(*regions_, readings, runs, false_alarms_per_hour);
  begin_sequence();
}

const LiveAnswer& LiveSolver::answer(const Eigen::Ref<const Eigen::RowVectorXd>& voltages,
                                     double time_s) {
  const SteadyClock::time_point start = SteadyClock::now();
  change_ = voltages - reference_;
  image();
  answer_.solver_s = seconds_since(start);
  answer_.tracks = tracker_.update(time_s, timed_contacts(found_[0], *sensor_.sheet));
  answer_.force_N = forces_ ? forces_->force_N(answer_.reading) : std::nullopt;
  answer_.alarm = collision_ ? std::optional(collision_->alarm(answer_.reading)) : std::nullopt;
  return answer_;
}

}  // namespace ertbench
