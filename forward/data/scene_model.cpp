#include "forward/data/scene_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {

Eigen::Matrix3d touch_bound(const DatasetSpec& spec, const SceneModel& model, const Touch& touch) {
  DatasetSpec faultless = spec;
  faultless.faults = {};
  const std::array<double, 3> steps = {0.1, 0.1, 0.01 * touch.force_N};
  std::vector<Scene> scenes = {still_scene(spec.sensor, {&touch, 1})};
  for (int parameter = 0; parameter < 3; ++parameter) {
    for (const double sign : {1.0, -1.0}) {
      Touch moved = touch;
      const double step = sign * steps[static_cast<std::size_t>(parameter)];
      if (parameter < 2) moved.place_mm[parameter] += step;
      if (parameter == 2) moved.force_N += step;
      scenes.push_back(still_scene(spec.sensor, {&moved, 1}));
    }
  }
  const std::vector<std::uint64_t> numbers(scenes.size(), 0);
  Frames voltages(static_cast<Eigen::Index>(scenes.size()), spec.sensor.channels());
  RowMajorMatrix effort(voltages.rows(), 0);
  model.solve(faultless, scenes, numbers, voltages, effort);
  Eigen::MatrixX3d jacobian(spec.sensor.channels(), 3);
  for (int parameter = 0; parameter < 3; ++parameter) {
    jacobian.col(parameter) =
        (voltages.row(1 + 2 * parameter) - voltages.row(2 + 2 * parameter)).transpose() /
        (2 * steps[static_cast<std::size_t>(parameter)]);
  }
  const double noise =  // of one channel, V
      noise_norm(spec.noise, model.reference_voltages(), voltages.row(0).transpose()) /
      std::sqrt(static_cast<double>(voltages.cols()));
  return (jacobian.transpose() * jacobian).inverse() * noise * noise;
}

namespace {

void solve_on_grid(const ForwardModel& model, const DatasetSpec& spec,
                   std::span<const Scene> scenes, std::span<const std::uint64_t> numbers,
                   Eigen::Ref<Frames> voltages) {
  // A few scenes at a time, because their fine images are large.
  const PixelGrid pixels = spec.sensor.sheet->pixels(model.grid());
  const Eigen::Index batch = model.grid() <= 48 ? 64 : 16;
  const auto count = static_cast<Eigen::Index>(scenes.size());
  Images sheets(std::min(batch, count), pixels.count());
  Eigen::VectorXd ratio(pixels.count());
  const Faults& faults = spec.faults;
  const bool mottled = faults.background_mottle > 0;
  const bool retaken = mottled && faults.displacement_reference == DisplacementReference::retaken;
  Images films(retaken ? sheets.rows() : 0, pixels.count());
  for (Eigen::Index start = 0; start < count; start += batch) {
    const Eigen::Index rows = std::min(batch, count - start);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto index = static_cast<std::size_t>(start + i);
      rasterise(scenes[index], pixels, spec.rasterisation, ratio);
      if (spec.faults.background_gradient > 0) {
        RandomStream random = spec.stream(numbers[index], Purpose::gradient);
        ratio.array() *= gradient_factors(spec.faults, *spec.sensor.sheet, pixels, random).array();
      }
      if (mottled) {
        RandomStream random = spec.stream(numbers[index], Purpose::gradient);
        const Eigen::VectorXd film = mottle_factors(faults, *spec.sensor.sheet, pixels, random);
        ratio.array() *= film.array();
        if (retaken) films.row(i) = spec.sensor.background * film;
      }
      sheets.row(i) = spec.sensor.background * ratio;
    }
    voltages.middleRows(start, rows) = model.solve(sheets.topRows(rows));
    if (!retaken) continue;
    voltages.middleRows(start, rows) -= model.solve(films.topRows(rows));
    voltages.middleRows(start, rows).rowwise() += model.reference_voltages().transpose();
  }
}

/// The model of electrodes that are where, as wide and as good as the faults have them.
BorderModel faulty_model(const DatasetSpec& spec, const Sensor& sensor, std::uint64_t number) {
  RandomStream random = spec.stream(number, Purpose::displacement);
  const Eigen::VectorXd displaced = displacements(spec.faults, sensor, random);
  return {sensor, displaced, impedance_factors(spec.faults, sensor, random)};
}

/// [channels, 2] V, for gradients of size one along x and y, to first order.
Eigen::MatrixX2d gradient_responses(const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  Eigen::MatrixX2d slopes = Eigen::MatrixX2d::Zero(pixels.count(), 2);
  for (int p = 0; p < pixels.count(); ++p) {
    if (pixels.on_sheet(p)) slopes.row(p) = pixels.centre(p) - middle;
  }
  return sensor.background * uniform_jacobian(sensor) * slopes;
}

void solve_on_borders(const BorderModel& nominal, const DatasetSpec& spec,
                      std::span<const Scene> scenes, std::span<const std::uint64_t> numbers,
                      Eigen::Ref<Frames> voltages, Eigen::Ref<RowMajorMatrix> effort) {
  const double model_error = std::get<ContinuousSheet>(spec.model).model_error;
  const Faults& faults = spec.faults;
  const Sensor sensor = with_faulty_electrodes(faults, spec.sensor);
  // Electrodes as they were when the reference was taken, whose voltages the set has as nominal.
  const BorderModel before(sensor);
  Eigen::MatrixX2d gradients;
  if (faults.background_gradient > 0) gradients = gradient_responses(spec.sensor);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    std::optional<BorderModel> displaced;
    if (faults.of_electrodes()) displaced.emplace(faulty_model(spec, sensor, numbers[i]));
    const BorderModel& model = displaced ? *displaced : nominal;
    Eigen::VectorXd reference = nominal.reference_voltages();
    if (faults.displacement_reference == DisplacementReference::stale) {
      reference += model.reference_voltages() - before.reference_voltages();
    }
    if (faults.background_gradient > 0) {
      RandomStream random = spec.stream(numbers[i], Purpose::gradient);
      reference += gradients * gradient_of(faults, *spec.sensor.sheet, random);
    }
    // Scaled like the frame in the set: a divider of its voltages divides their error, too.
    const double divisor = 1 + spec.faults.background_change;
    const auto tolerance = [&](const Eigen::VectorXd& change) {
      return model_error * divisor *
             noise_norm(spec.noise, nominal.reference_voltages(), (reference + change) / divisor);
    };
    const BorderModel::Solution solution = model.solve(scenes[i], tolerance);
    const auto row = static_cast<Eigen::Index>(i);
    voltages.row(row) = reference + solution.change;
    effort.row(row) << solution.points, solution.error / divisor;
  }
}

/// Steps in which a moving pressure is followed; it is linear within each.
constexpr double longest_step_s = 0.004;

const SequenceSet& set_of(const DatasetSpec& spec) { return std::get<SequenceSet>(spec.scenes); }

TouchSequence sequence_of(const DatasetSpec& spec, std::uint64_t sequence) {
  RandomStream random = spec.stream(sequence, Purpose::scene);
  return set_of(spec).draw(sequence, random, spec.sensor);
}

/// True up to rounding.
bool equal(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b).cwiseAbs().maxCoeff() <= 1e-12 * a.cwiseAbs().maxCoeff();
}

bool same_place_and_force(const std::vector<Touch>& a, const std::vector<Touch>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Touch& x, const Touch& y) {
    return x.force_N == y.force_N && (x.force_N == 0 || x.place_mm == y.place_mm);
  });
}

}  // namespace

struct SceneModel::Parts {
  std::optional<ForwardModel> grid;
  std::optional<BorderModel> borders;
};

SceneModel::SceneModel(const Sensor& sensor, const SheetModel& model)
    : parts_(std::make_unique<Parts>()) {
  if (const auto* grid = std::get_if<GridSheet>(&model)) {
    parts_->grid.emplace(sensor, grid->side);
  } else {
    parts_->borders.emplace(sensor);
  }
}
SceneModel::~SceneModel() = default;
SceneModel::SceneModel(SceneModel&&) noexcept = default;

const Eigen::VectorXd& SceneModel::reference_voltages() const {
  return parts_->borders ? parts_->borders->reference_voltages()
                         : parts_->grid->reference_voltages();
}

void SceneModel::solve(const DatasetSpec& spec, std::span<const Scene> scenes,
                       std::span<const std::uint64_t> numbers, Eigen::Ref<Frames> voltages,
                       Eigen::Ref<RowMajorMatrix> effort) const {
  if (parts_->borders) {
    solve_on_borders(*parts_->borders, spec, scenes, numbers, voltages, effort);
  } else {
    solve_on_grid(*parts_->grid, spec, scenes, numbers, voltages);
  }
  voltages /= 1 + spec.faults.background_change;
}

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
      // All frames before had a single scene.
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

  /// Solves the wanted drives of each frame; rows of a frame are consecutive.
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
