#include "bench/contacts/tracker.h"

#include <algorithm>
#include <stdexcept>

#include "bench/contacts/assignment.h"

namespace ertbench {

std::vector<TimedContact> timed_contacts(std::span<const FoundContact> contacts,
                                         const Sheet& sheet) {
  std::vector<TimedContact> out;
  for (const FoundContact& contact : contacts) {
    out.push_back({sheet.unit_mm() * (contact.place - sheet.bounds().center())});
  }
  return out;
}

Tracker::Tracker(const TrackerSettings& settings) : settings_(settings) {
  const bool positive = settings.acceleration_mm_s2 > 0 && settings.measurement_mm > 0 &&
                        settings.speed_mm_s > 0 && settings.gate_mm > 0;
  if (!positive) {
    throw std::invalid_argument("a tracker's deviations and its gate must be > 0");
  }
  if (settings.confirm_frames < 1 || settings.confirm_window < settings.confirm_frames) {
    throw std::invalid_argument("a track is confirmed by 1 frame or more out of at least as many");
  }
  if (!(settings.patience_s >= 0) || settings.patience_frames < 1) {
    throw std::invalid_argument("a tracker's patience must be >= 0 s and 1 frame or more");
  }
}

std::vector<TrackPoint> Tracker::update(double time_s, std::span<const TimedContact> contacts) {
  if (!tracks_.empty() && !(time_s > time_s_)) {
    throw std::invalid_argument("a tracker's frames must be in the order of their times");
  }
  Eigen::MatrixXd distance(std::ssize(tracks_), std::ssize(contacts));
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    ConstantVelocity& motion = tracks_[t].motion;
    motion.predict(time_s - time_s_, settings_.acceleration_mm_s2);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const Eigen::Vector2d expected =
          motion.place_mm() - contacts[c].ago_s * motion.velocity_mm_s();
      distance(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(c)) =
          (contacts[c].place_mm - expected).norm();
    }
  }
  time_s_ = time_s;

  std::vector<const TimedContact*> contact_of(tracks_.size(), nullptr);
  std::vector<bool> taken(contacts.size(), false);
  for (const auto& [track, contact] : assign(distance, settings_.gate_mm).pairs) {
    contact_of[static_cast<std::size_t>(track)] = &contacts[static_cast<std::size_t>(contact)];
    taken[static_cast<std::size_t>(contact)] = true;
  }
  for (std::size_t t = 0; t < tracks_.size(); ++t) take_in(tracks_[t], time_s, contact_of[t]);
  std::erase_if(tracks_, [&](const Track& track) { return is_over(track, time_s); });
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (taken[c]) continue;
    ConstantVelocity motion(contacts[c].place_mm, settings_.measurement_mm, settings_.speed_mm_s);
    motion.predict(contacts[c].ago_s, settings_.acceleration_mm_s2);
    Track track{next_id_++, motion, time_s};
    track.confirmed = settings_.confirm_frames == 1;
    tracks_.push_back(track);
  }

  std::vector<TrackPoint> points;
  for (const Track& track : tracks_) {
    points.push_back({track.id, track.motion.place_mm(), track.motion.velocity_mm_s(),
                      track.motion.covariance(), track.confirmed, track.frames_missed == 0});
  }
  return points;
}

void Tracker::take_in(Track& track, double time_s, const TimedContact* contact) const {
  ++track.frames;
  if (contact == nullptr) {
    ++track.frames_missed;
    return;
  }
  track.motion.update(contact->place_mm, contact->ago_s, settings_.measurement_mm);
  track.last_seen_s = time_s;
  track.frames_missed = 0;
  ++track.frames_seen;
  if (track.frames_seen >= settings_.confirm_frames) track.confirmed = true;
}

bool Tracker::is_over(const Track& track, double time_s) const {
  // A track that is confirmed in its window or forgotten at its end needs no memory of each frame.
  if (!track.confirmed) return track.frames >= settings_.confirm_window;
  return track.frames_missed >= settings_.patience_frames &&
         time_s - track.last_seen_s >= settings_.patience_s;
}

}  // namespace ertbench
