#include "forward/data/sequence_frames.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

/// Steps in which a moving pressure is followed, as its path from one to the next is taken for
/// straight.
constexpr double longest_step_s = 0.004;

const SequenceSet& set_of(const DatasetSpec& spec) { return std::get<SequenceSet>(spec.scenes); }

TouchSequence sequence_of(const DatasetSpec& spec, std::uint64_t sequence) {
  RandomStream random = spec.stream(sequence, Purpose::scene);
  return set_of(spec).draw(sequence, random, spec.sensor);
}

/// But for rounding.
bool equal(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b).cwiseAbs().maxCoeff() <= 1e-12 * a.cwiseAbs().maxCoeff();
}

bool same_place_and_force(const std::vector<Touch>& a, const std::vector<Touch>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Touch& x, const Touch& y) {
    return x.force_N == y.force_N && (x.force_N == 0 || x.place_mm == y.place_mm);
  });
}

}  // namespace

SequenceFrames::SequenceFrames(const DatasetSpec& spec, std::uint64_t sequence)
    : spec_(spec),
      timing_(set_of(spec).timing()),
      sequence_(sequence_of(spec, sequence)),
      touches_(sequence_.at(0)),
      relaxed_kPa_(relaxed_pressure_kPa(spec.sensor, touches_)),
      foam_(spec.sensor.skin->foam, relaxed_kPa_) {}

void SequenceFrames::move_to(double time_s) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil((time_s - now_s_) / longest_step_s - 1e-9)));
  const double start = now_s_;
  for (int step = 1; step <= steps; ++step) {
    const double then = start + (time_s - start) * step / steps;
    std::vector<Touch> touches = sequence_.at(then);
    if (!same_place_and_force(touches, touches_)) {
      relaxed_kPa_ = relaxed_pressure_kPa(spec_.sensor, touches);
      touches_ = std::move(touches);
    }
    foam_.advance(then - now_s_, relaxed_kPa_);
    now_s_ = then;
  }
}

SequenceFrames::Frame SequenceFrames::next() {
  const int drives = spec_.sensor.drives();
  Frame out;
  std::vector<Eigen::VectorXd> pressures;
  const auto look = [&] { return skin_scene(spec_.sensor, touches_, foam_.pressure_kPa()); };
  bool still = true;
  for (int drive = 0; drive < drives; ++drive) {
    if (2 * drive == drives || (2 * drive == drives + 1)) {
      out.time_s = timing_.middle_s(frame_, drives);
      move_to(out.time_s);
      out.truth = look();
    }
    move_to(timing_.drive_s(frame_, drive, drives));
    pressures.push_back(foam_.pressure_kPa());
    still = still && equal(pressures.front(), pressures.back());
    if (drive == 0 || !still) {
      // Those before were all alike.
      while (out.drives.size() < pressures.size() - 1) out.drives.push_back(out.drives.front());
      out.drives.push_back(look());
    }
  }
  frame_ += 1;
  return out;
}

void SequenceFrames::skip(std::uint64_t frames) {
  if (frames == 0) return;
  frame_ += static_cast<double>(frames);
  move_to(timing_.end_s(frame_ - 1));
}

void solve_drives(const DatasetSpec& spec, const SceneModel& model,
                  const std::vector<SequenceFrames::Frame>& frames,
                  const std::vector<std::uint64_t>& numbers, double tolerance,
                  Eigen::Ref<Frames> voltages) {
  const std::vector<Channel> channels = channels_of(spec.sensor);
  const int drives = spec.sensor.drives();
  const int middle = drives / 2;

  /// Solves the wanted drives of each frame; its rows follow each other.
  const auto solve = [&](const std::vector<std::size_t>& which,
                         const std::vector<std::vector<int>>& wanted) {
    std::vector<Scene> scenes;
    std::vector<std::uint64_t> number;
    for (const std::size_t f : which) {
      for (const int drive : wanted[f]) {
        scenes.push_back(frames[f].drives[static_cast<std::size_t>(drive)]);
        number.push_back(numbers[f]);
      }
    }
    Frames solved(static_cast<Eigen::Index>(scenes.size()), voltages.cols());
    RowMajorMatrix effort(solved.rows(), 0);
    model.solve(spec, scenes, number, solved, effort);
    return solved;
  };

  std::vector<std::size_t> all;
  std::vector<std::vector<int>> wanted(frames.size());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    all.push_back(f);
    wanted[f] = frames[f].drives.size() == 1 ? std::vector<int>{0}
                                             : std::vector<int>{0, middle, drives - 1};
  }
  const Frames few = solve(all, wanted);
  std::vector<std::size_t> moving;
  Eigen::Index row = 0;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto out = static_cast<Eigen::Index>(f);
    if (wanted[f].size() == 1) {
      voltages.row(out) = few.row(row++);
      continue;
    }
    const Eigen::RowVectorXd first = few.row(row);
    const Eigen::RowVectorXd half = few.row(row + 1);
    const Eigen::RowVectorXd last = few.row(row + 2);
    row += 3;
    const double m = static_cast<double>(middle) / (drives - 1);
    const Eigen::RowVectorXd bend = half - ((1 - m) * first + m * last);
    if (bend.norm() > tolerance * noise_norm(spec.noise, model.reference_voltages(), half)) {
      moving.push_back(f);
      continue;
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const double t = static_cast<double>(channels[c].drive) / (drives - 1);
      voltages(out, i) = (1 - t) * first[i] + t * last[i] + bend[i] * t * (1 - t) / (m * (1 - m));
    }
  }

  for (const std::size_t f : moving) {
    wanted[f].clear();
    for (int drive = 0; drive < drives; ++drive) wanted[f].push_back(drive);
  }
  const Frames each = solve(moving, wanted);
  for (std::size_t n = 0; n < moving.size(); ++n) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      voltages(static_cast<Eigen::Index>(moving[n]), i) =
          each(static_cast<Eigen::Index>(n) * drives + channels[c].drive, i);
    }
  }
}

}  // namespace ertbench
