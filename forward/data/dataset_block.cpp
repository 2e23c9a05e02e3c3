#include "forward/data/dataset_block.h"

#include <algorithm>
#include <future>

#include "forward/data/dataset_layout.h"
#include "forward/data/scene_model.h"
#include "forward/data/sequence_frames.h"

namespace ertbench {

namespace layout = dataset_layout;

namespace {

DatasetBlock allocate(const DatasetSpec& spec, std::uint64_t count) {
  const auto rows = static_cast<Eigen::Index>(count);
  const auto contacts = static_cast<Eigen::Index>(layout::contact_width(spec));
  DatasetBlock block;
  block.voltages.resize(rows, spec.sensor.channels());
  block.clean_voltages.resize(rows, spec.sensor.channels());
  block.conductivity.resize(rows, spec.sensor.pixels());
  block.effort.resize(rows, static_cast<Eigen::Index>(layout::effort_columns_of(spec)));
  block.contacts.resize(rows, contacts * layout::contact_columns);
  block.vertices.resize(rows, contacts * 2 * static_cast<Eigen::Index>(spec.most_vertices()));
  block.forces.resize(rows, spec.has_touches() ? contacts : 0);
  block.moments.resize(rows, spec.sequences() ? 2 : 0);
  block.truths.resize(count);
  return block;
}

/// Rows [begin, end) of a block that starts at scene `first`.
struct Part {
  const DatasetSpec& spec;
  const SceneModel& model;
  std::uint64_t first;
  Eigen::Index begin;
  Eigen::Index end;

  Eigen::Index count() const { return end - begin; }
  std::uint64_t number(Eigen::Index row) const { return first + static_cast<std::uint64_t>(row); }
};

/// Clean voltages and truths of scenes at rest; one that several rows show is solved once.
void fill_scenes(const Part& part, DatasetBlock& block) {
  const DatasetSpec& spec = part.spec;
  std::vector<Scene> scenes;
  std::vector<std::uint64_t> numbers;
  std::vector<Eigen::Index> solved;  // [rows] which of them
  for (Eigen::Index row = part.begin; row < part.end; ++row) {
    const std::uint64_t index = part.number(row);
    // Faults of the sheet are drawn for each frame.
    const bool again = row > part.begin && !spec.faults.of_sheet() &&
                       !std::holds_alternative<std::vector<Scene>>(spec.scenes) &&
                       spec.scene_number(index) == spec.scene_number(index - 1);
    if (!again) {
      scenes.push_back(spec.scene(index));
      numbers.push_back(index);
    }
    solved.push_back(static_cast<Eigen::Index>(scenes.size()) - 1);
    block.truths[static_cast<std::size_t>(row)] = scenes.back();
  }
  const auto count = static_cast<Eigen::Index>(scenes.size());
  Frames voltages(count, spec.sensor.channels());
  RowMajorMatrix effort(count, block.effort.cols());
  part.model.solve(spec, scenes, numbers, voltages, effort);
  for (Eigen::Index i = 0; i < part.count(); ++i) {
    const Eigen::Index from = solved[static_cast<std::size_t>(i)];
    block.clean_voltages.row(part.begin + i) = voltages.row(from);
    block.effort.row(part.begin + i) = effort.row(from);
  }
}

/// The same of frames of sequences. The skin has a memory: where the rows begin within a sequence,
/// what went before is gone through without being solved.
void fill_sequences(const Part& part, DatasetBlock& block) {
  constexpr std::size_t frames_at_a_time = 64;
  const DatasetSpec& spec = part.spec;
  const SequenceSet& set = *spec.sequences();
  std::vector<SequenceFrames::Frame> frames;
  std::vector<std::uint64_t> numbers;
  Eigen::Index row = part.begin;
  const auto flush = [&] {
    const auto count = static_cast<Eigen::Index>(frames.size());
    solve_drives(spec, part.model, frames, numbers, drive_tolerance,
                 block.clean_voltages.middleRows(row - count, count));
    frames.clear();
    numbers.clear();
  };
  while (row < part.end) {
    const std::uint64_t sequence = set.sequence_of(part.number(row));
    SequenceFrames measured(spec, sequence);
    measured.skip(part.number(row) - set.first_frame(sequence));
    const std::uint64_t behind = set.first_frame(sequence) + set.frames_of(sequence);
    for (; row < part.end && part.number(row) < behind; ++row) {
      frames.push_back(measured.next());
      numbers.push_back(sequence);
      block.truths[static_cast<std::size_t>(row)] = frames.back().truth;
      block.moments.row(row) << frames.back().time_s, static_cast<double>(sequence);
      if (frames.size() == frames_at_a_time) {
        ++row;
        flush();
        --row;
      }
    }
    if (!frames.empty()) flush();
  }
}

void fill_rows(const Part& part, DatasetBlock& block) {
  if (part.count() == 0) return;
  const DatasetSpec& spec = part.spec;
  if (spec.sequences()) {
    fill_sequences(part, block);
  } else {
    fill_scenes(part, block);
  }
  const PixelGrid pixels = spec.sensor.image();
  const Eigen::VectorXd& reference = part.model.reference_voltages();
  Eigen::VectorXd image(pixels.count());
  for (Eigen::Index i = part.begin; i < part.end; ++i) {
    const std::uint64_t index = part.number(i);
    const Scene& truth = block.truths[static_cast<std::size_t>(i)];
    layout::pack(truth, block.contacts.row(i), block.vertices.row(i));
    if (block.forces.cols() > 0) layout::pack_forces(truth, block.forces.row(i));
    rasterise(truth, pixels, spec.rasterisation, image);
    block.conductivity.row(i) = spec.sensor.background * image;

    const double age =
        spec.faults.reference_age_s + (block.moments.cols() > 0 ? block.moments(i, 0) : 0);
    block.clean_voltages.row(i) /= drift_factor(spec.faults, age);
    RandomStream noise = spec.noise_stream(index);
    RandomStream battery = spec.stream(index, Purpose::battery);
    RandomStream fault = spec.stream(spec.fault_number(index), Purpose::fault);
    Eigen::VectorXd frame =
        battery_factor(spec.faults, age, battery) * block.clean_voltages.row(i).transpose();
    add_noise(spec.noise, reference, noise, frame);
    apply_faults(spec.faults, spec.sensor, reference, fault, frame);
    block.voltages.row(i) = frame;
  }
}

}  // namespace

DatasetBlock generate_block(const DatasetSpec& spec, const SceneModel& model, std::uint64_t first,
                            std::uint64_t count, int threads) {
  DatasetBlock block = allocate(spec, count);
  const auto rows = static_cast<Eigen::Index>(count);
  const auto part = [&](int t) {
    return Part{spec, model, first, rows * t / threads, rows * (t + 1) / threads};
  };
  if (threads <= 1) {
    fill_rows(part(0), block);
    return block;
  }
  std::vector<std::future<void>> workers;
  for (int t = 0; t < threads; ++t) {
    workers.push_back(std::async(std::launch::async, [&, t] { fill_rows(part(t), block); }));
  }
  for (auto& worker : workers) worker.wait();
  for (auto& worker : workers) worker.get();
  return block;
}

}  // namespace ertbench
