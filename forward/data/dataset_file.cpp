#include "forward/data/dataset_file.h"

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json_reader.h"
#include "forward/data/dataset_layout.h"

namespace ertbench {

namespace layout = dataset_layout;

namespace {

/// An attribute of the root.
nlohmann::json json_attribute(const Hdf5File& file, const std::string& name) {
  return parse_json(file.read_text("/", name),
                    file.path().string() + ": attribute \"" + name + "\" of /");
}

/// What the root's attribute "truth" lists; of generated sets, which have none, all is known.
Truth written_truth(const Hdf5File& file) {
  if (!file.has_attribute("/", layout::truth)) return {};
  const std::string text = file.read_text("/", layout::truth);
  return {text.find("images") != std::string::npos, text.find("places") != std::string::npos};
}

}  // namespace

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
  const RowMajorMatrix contacts = file_->read_rows(layout::contacts, first, count, true);
  RowMajorMatrix vertices(contacts.rows(), 0);
  if (file_->has(layout::contact_vertices)) {
    vertices = file_->read_rows(layout::contact_vertices, first, count, true);
  }
  RowMajorMatrix forces(contacts.rows(), 0);
  if (file_->has(layout::forces)) forces = file_->read_rows(layout::forces, first, count, true);
  std::vector<Scene> scenes;
  for (Eigen::Index i = 0; i < contacts.rows(); ++i) {
    scenes.push_back(layout::unpack(contacts.row(i), vertices.row(i)));
    layout::unpack_forces(forces.row(i), scenes.back());
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
