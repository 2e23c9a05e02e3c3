#include "forward/data/dataset_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/process.h"
#include "forward/data/scene_model.h"

namespace ertbench::dataset_layout {

std::uint64_t contact_width(const DatasetSpec& spec) {
  return std::max<std::size_t>(1, spec.most_contacts());
}

std::uint64_t effort_columns_of(const DatasetSpec& spec) {
  return std::holds_alternative<ContinuousSheet>(spec.model) ? effort_columns : 0;
}

void pack(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> contact_row,
          Eigen::Ref<Eigen::RowVectorXd> vertex_row) {
  constexpr double absent = std::numeric_limits<double>::quiet_NaN();
  contact_row.setConstant(absent);
  vertex_row.setConstant(absent);
  const Eigen::Index vertex_columns =
      vertex_row.size() / std::max<Eigen::Index>(1, contact_row.size() / contact_columns);
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    const Contact& contact = scene.contacts[k];
    const Eigen::Vector2d centre = contact.centroid();
    auto row = contact_row.segment(static_cast<Eigen::Index>(k) * contact_columns, contact_columns);
    row[0] = static_cast<double>(contact.shape);
    row[1] = centre.x();
    row[2] = centre.y();
    row[6] = contact.conductivity_ratio;
    if (contact.shape != Shape::polygon) {
      row[3] = contact.half_size.x();
      row[4] = contact.half_size.y();
      row[5] = contact.angle;
    }
    for (std::size_t v = 0; v < contact.vertices.size(); ++v) {
      vertex_row.segment<2>(static_cast<Eigen::Index>(k) * vertex_columns +
                            2 * static_cast<Eigen::Index>(v)) = contact.vertices[v].transpose();
    }
  }
}

Scene unpack(const Eigen::Ref<const Eigen::RowVectorXd>& contact_row,
             const Eigen::Ref<const Eigen::RowVectorXd>& vertex_row) {
  Scene scene;
  const Eigen::Index count = contact_row.size() / contact_columns;
  const Eigen::Index vertex_columns = vertex_row.size() / std::max<Eigen::Index>(1, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto row = contact_row.segment(k * contact_columns, contact_columns);
    if (!(row[0] >= 0 && row[0] <= 3)) continue;
    Contact contact;
    contact.shape = static_cast<Shape>(static_cast<int>(row[0]));
    contact.centre = {row[1], row[2]};
    contact.conductivity_ratio = row[6];
    if (contact.shape == Shape::polygon) {
      const auto vertices = vertex_row.segment(k * vertex_columns, vertex_columns);
      for (Eigen::Index v = 0; v + 1 < vertex_columns && std::isfinite(vertices[v]); v += 2) {
        contact.vertices.emplace_back(vertices[v], vertices[v + 1]);
      }
      if (contact.vertices.size() < 3) continue;
    } else {
      contact.half_size = {row[3], row[4]};
      contact.angle = row[5];
    }
    scene.contacts.push_back(std::move(contact));
  }
  return scene;
}

void pack_forces(const Scene& scene, Eigen::Ref<Eigen::RowVectorXd> row) {
  row.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    row[static_cast<Eigen::Index>(k)] = scene.contacts[k].force_N;
  }
}

void unpack_forces(const Eigen::Ref<const Eigen::RowVectorXd>& row, Scene& scene) {
  const auto known = std::min(row.size(), static_cast<Eigen::Index>(scene.contacts.size()));
  for (Eigen::Index k = 0; k < known; ++k) {
    if (row[k] > 0) scene.contacts[static_cast<std::size_t>(k)].force_N = row[k];
  }
}

std::vector<Scene> read_scenes(const Hdf5File& file, std::uint64_t first, std::uint64_t count) {
  const RowMajorMatrix rows = file.read_rows(contacts, first, count, true);
  RowMajorMatrix vertices(rows.rows(), 0);
  if (file.has(contact_vertices)) vertices = file.read_rows(contact_vertices, first, count, true);
  std::vector<Scene> scenes;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    scenes.push_back(unpack(rows.row(i), vertices.row(i)));
  }
  return scenes;
}

}  // namespace ertbench::dataset_layout

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

/// Clean voltages and truths of scenes at rest. A scene that several rows share is solved once.
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

/// As above for frames of sequences. The skin has a memory, so that frames of the sequence before
/// the first row are simulated without being solved.
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

/// An attribute of the root.
nlohmann::json json_attribute(const Hdf5File& file, const std::string& name) {
  return parse_json(file.read_text("/", name),
                    file.path().string() + ": attribute \"" + name + "\" of /");
}

/// Reads the root attribute "truth"; generated sets have none, and everything is known.
Truth written_truth(const Hdf5File& file) {
  if (!file.has_attribute("/", layout::truth)) return {};
  const std::string text = file.read_text("/", layout::truth);
  return {text.find("images") != std::string::npos, text.find("places") != std::string::npos};
}

}  // namespace

DatasetBlock generate_block(const DatasetSpec& spec, const SceneModel& model, std::uint64_t first,
                            std::uint64_t count, int threads) {
  DatasetBlock block = allocate(spec, count);
  parallel_for(count, threads, [&](std::size_t begin, std::size_t end) {
    fill_rows(
        {spec, model, first, static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end)},
        block);
  });
  return block;
}

std::string written_recipe(const Hdf5File& file) {
  if (file.has(layout::recipe)) return file.read_text_dataset(layout::recipe);
  return file.has_attribute("/", "recipe") ? file.read_text("/", "recipe") : "";
}

std::optional<BuildStamp> written_build(const Hdf5File& file) {
  if (!file.has_attribute("/", "build")) return std::nullopt;
  return build_stamp_from_json(json_attribute(file, "build"));
}

DatasetFile::DatasetFile(const std::filesystem::path& file)
    : path_(file),
      file_(std::make_unique<Hdf5File>(Hdf5File::open(file))),
      sensor_(sensor_of(*file_)),
      recipe_(written_recipe(*file_)),
      build_(written_build(*file_)),
      truth_(written_truth(*file_)) {
  const auto channels = static_cast<std::uint64_t>(sensor_.channels());
  const auto rows = static_cast<std::uint64_t>(sensor_.image_rows());
  const auto columns = static_cast<std::uint64_t>(sensor_.image_columns());
  size_ = file_->require_shape(layout::voltages, {0, channels})[0];
  if (file_->has(layout::scenes_written) &&
      file_->read_rows(layout::scenes_written, 0, 1)(0, 0) != static_cast<double>(size_)) {
    throw InputError(file.string() +
                     ": is not finished; generate it again under the same name to go on");
  }
  file_->require_shape(layout::clean_voltages, {size_, channels});
  file_->require_shape(layout::conductivity, {size_, rows, columns});
  file_->require_shape(layout::contacts, {size_, 0, layout::contact_columns});
  file_->require_shape(layout::reference_voltages, {channels});
  if (file_->has(layout::model_effort)) {
    file_->require_shape(layout::model_effort, {size_, layout::effort_columns});
  }
  if (file_->has(layout::forces)) file_->require_shape(layout::forces, {size_, 0});
  for (const std::string& moment : {layout::time, layout::sequence}) {
    if (file_->has(moment)) file_->require_shape(moment, {size_});
  }
  reference_ = file_->read_vector(layout::reference_voltages);
}

DatasetFile::DatasetFile(DatasetFile&&) noexcept = default;
DatasetFile::~DatasetFile() = default;

std::string DatasetFile::why_changed() const { return file_->why_changed(); }

DatasetSpec DatasetFile::spec() const {
  nlohmann::json recipe;
  if (!recipe_.empty()) recipe = parse_json(recipe_, path_.string() + ": /recipe");
  if (!recipe.is_object() || !recipe.contains("name") || !recipe["name"].is_string()) {
    throw InputError(path_.string() +
                     ": /recipe: does not say how the set was made; generate it again");
  }
  const std::string name = recipe["name"];
  for (const char* key : {"format_version", "sensor", "name"}) recipe.erase(key);
  return dataset_spec_from_json(JsonObject(recipe, path_.string(), "/recipe"), sensor_, name);
}

Frames DatasetFile::voltages(std::uint64_t first, std::uint64_t count) const {
  return file_->read_rows(layout::voltages, first, count);
}

Frames DatasetFile::clean_voltages(std::uint64_t first, std::uint64_t count) const {
  return file_->read_rows(layout::clean_voltages, first, count);
}

Images DatasetFile::conductivity(std::uint64_t first, std::uint64_t count) const {
  return file_->read_rows(layout::conductivity, first, count);
}

Eigen::VectorXd DatasetFile::model_errors(std::uint64_t first, std::uint64_t count) const {
  if (!file_->has(layout::model_effort)) return {};
  return file_->read_rows(layout::model_effort, first, count).col(layout::effort_columns - 1);
}

std::vector<Scene> DatasetFile::scenes(std::uint64_t first, std::uint64_t count) const {
  std::vector<Scene> scenes = layout::read_scenes(*file_, first, count);
  if (!file_->has(layout::forces)) return scenes;
  const RowMajorMatrix forces = file_->read_rows(layout::forces, first, count, true);
  for (Eigen::Index i = 0; i < forces.rows(); ++i) {
    layout::unpack_forces(forces.row(i), scenes[static_cast<std::size_t>(i)]);
  }
  return scenes;
}

Eigen::VectorXd DatasetFile::times(std::uint64_t first, std::uint64_t count) const {
  if (!file_->has(layout::time)) return {};
  return file_->read_rows(layout::time, first, count).col(0);
}

Eigen::VectorXd DatasetFile::sequences(std::uint64_t first, std::uint64_t count) const {
  if (!file_->has(layout::sequence)) return {};
  return file_->read_rows(layout::sequence, first, count).col(0);
}

Sensor sensor_of(const Hdf5File& file) {
  if (!file.has_attribute("/", "sensor")) return {};
  const nlohmann::json json = json_attribute(file, "sensor");
  return sensor_from_json(
      JsonObject(json, file.path().string() + ": attribute \"sensor\" of /", ""));
}

}  // namespace ertbench
