#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/data/scene_model.h"
#include "python/module/arrays.h"

namespace ertbench {
namespace {

DatasetSpec spec_of(const Sensor& sensor, const std::string& text, const std::string& name) {
  const nlohmann::json json = parse_json(text, "Scenes");
  return dataset_spec_from_json(JsonObject(json, "Scenes", ""), sensor, name);
}

/// The arrays of a set, filled block by block.
class SetArrays {
 public:
  SetArrays(const Sensor& sensor, std::uint64_t count, std::uint64_t contacts,
            std::uint64_t vertices)
      : voltages_({size(count), size(sensor.channels())}),
        clean_({size(count), size(sensor.channels())}),
        images_({size(count), size(sensor.image_rows()), size(sensor.image_columns())}),
        contacts_({size(count), size(contacts), size(dataset_layout::contact_columns)}),
        vertices_({size(count), size(contacts), size(vertices), py::ssize_t{2}}) {}

  void put(std::uint64_t first, const DatasetBlock& block) {
    put(voltages_, first, block.voltages);
    put(clean_, first, block.clean_voltages);
    put(images_, first, block.conductivity);
    put(contacts_, first, block.contacts);
    put(vertices_, first, block.vertices);
  }

  py::dict dict(const Eigen::VectorXd& reference) const {
    py::dict out;
    out["voltages"] = voltages_;
    out["clean_voltages"] = clean_;
    out["images"] = images_;
    out["contacts"] = contacts_;
    out["vertices"] = vertices_;
    out["reference"] = array_of(reference.transpose(), {reference.size()});
    return out;
  }

 private:
  template <typename Integer>
  static py::ssize_t size(Integer number) {
    return static_cast<py::ssize_t>(number);
  }
  /// Needs no lock of Python's: the arrays are there.
  static void put(Array& array, std::uint64_t first, const RowMajorMatrix& rows) {
    if (rows.size() == 0) return;
    std::copy(rows.data(), rows.data() + rows.size(),
              array.mutable_data() + static_cast<Eigen::Index>(first) * rows.cols());
  }

  Array voltages_, clean_, images_, contacts_, vertices_;
};

py::dict draw(const Sensor& sensor, const std::string& text, const std::string& name, int threads) {
  const DatasetSpec spec = spec_of(sensor, text, name);
  const SceneModel model(sensor, spec.model);
  SetArrays arrays(sensor, spec.count, dataset_layout::contact_width(spec), spec.most_vertices());
  for_blocks(static_cast<Eigen::Index>(spec.count), 64, threads, [&](auto begin, auto end) {
    const auto first = static_cast<std::uint64_t>(begin);
    arrays.put(first, generate_block(spec, model, first, static_cast<std::uint64_t>(end) - first));
  });
  return arrays.dict(recorded_reference(spec.faults, model.reference_voltages()));
}

/// Writes the set as the program's `generate` does.
void generate(const Sensor& sensor, const std::string& text, const std::string& name,
              const std::string& file, int threads) {
  const DatasetSpec spec = spec_of(sensor, text, name);
  threads = threads_of(threads);
  const Hdf5Turn turn;
  const py::gil_scoped_release unlocked;
  require_dataset_output(file, {});
  generate_dataset(spec, file, {threads, [](std::uint64_t, std::uint64_t) {
                                  const py::gil_scoped_acquire locked;
                                  check_signals();
                                }});
}

/// Writes a set that was put together, [N, ...] each, without contacts, noise or a recipe.
void write_scenes(const Sensor& sensor, const py::object& voltages, const py::object& images,
                  const py::object& reference, const std::string& path) {
  namespace layout = dataset_layout;
  const Rows frames = rows_of(voltages, "voltages", {sensor.channels()}, "V");
  const Rows truths =
      rows_of(images, "images", {sensor.image_rows(), sensor.image_columns()}, "S/m");
  const Rows zero = rows_of(reference, "reference", {sensor.channels()}, "V");
  if (frames.count != truths.count || frames.single || truths.single || !zero.single) {
    throw InputError("SceneSet: voltages and images must be as many, got " +
                     shape_text(frames.array) + " and " + shape_text(truths.array));
  }
  if (truths.count > 0 && truths.view().minCoeff() <= 0) {
    throw InputError(
        "SceneSet: images must be > 0 S/m everywhere; they are conductivities, not their changes");
  }
  const Hdf5Turn turn;
  require_dataset_output(path, {});
  replace_file(path, [&](const std::filesystem::path& aside) {
    Hdf5File file = Hdf5File::create(aside);
    const auto count = static_cast<std::uint64_t>(frames.count);
    file.write_matrix(layout::voltages, frames.view());
    file.write_matrix(layout::clean_voltages, frames.view());
    file.write_vector(layout::reference_voltages, zero.view().row(0).transpose());
    file.create_dataset(layout::conductivity,
                        {count, static_cast<std::uint64_t>(sensor.image_rows()),
                         static_cast<std::uint64_t>(sensor.image_columns())});
    file.write_rows(layout::conductivity, 0, truths.view());
    file.create_dataset(layout::contacts, {count, 1, layout::contact_columns});
    file.write_rows(layout::contacts, 0,
                    RowMajorMatrix::Constant(frames.count, layout::contact_columns, std::nan("")));
    file.write_text("/", "sensor", json_text(to_json(sensor)));
    file.write_text("/", layout::truth, "images");
    file.close();
  });
}

/// Reads a dataset file: its sensor, its arrays, and what made it, as JSON text ("" if unknown).
py::tuple read_scenes(const std::string& path) {
  constexpr std::uint64_t rows_at_once = 4096;
  const Hdf5Turn turn;
  const DatasetFile file(path);
  const Sensor& sensor = file.sensor();
  std::string spec_text, name;
  std::uint64_t contacts = 1, vertices = 0;
  try {
    const DatasetSpec spec = file.spec();
    spec_text = json_text(to_json(spec));
    name = spec.name;
  } catch (const InputError&) {  // from elsewhere: its arrays are all that is known
  }
  std::vector<Scene> scenes = file.scenes(0, file.size());
  for (const Scene& scene : scenes) {
    contacts = std::max<std::uint64_t>(contacts, scene.contacts.size());
    for (const Contact& contact : scene.contacts) {
      vertices = std::max<std::uint64_t>(vertices, contact.vertices.size());
    }
  }
  SetArrays arrays(sensor, file.size(), contacts, vertices);
  for (std::uint64_t first = 0; first < file.size(); first += rows_at_once) {
    const std::uint64_t count = std::min(rows_at_once, file.size() - first);
    const auto rows = static_cast<Eigen::Index>(count);
    DatasetBlock block;
    block.voltages = file.voltages(first, count);
    block.clean_voltages = file.clean_voltages(first, count);
    block.conductivity = file.conductivity(first, count);
    block.contacts.resize(rows,
                          static_cast<Eigen::Index>(contacts) * dataset_layout::contact_columns);
    block.vertices.resize(rows, static_cast<Eigen::Index>(contacts * vertices * 2));
    for (Eigen::Index i = 0; i < rows; ++i) {
      dataset_layout::pack(scenes[first + static_cast<std::uint64_t>(i)], block.contacts.row(i),
                           block.vertices.row(i));
    }
    arrays.put(first, block);
    check_signals();
  }
  py::dict out = arrays.dict(file.reference_voltages());
  for (const char* part : {"contacts", "vertices"}) {
    if (!file.truth().places) out[part] = py::none();
  }
  return py::make_tuple(sensor, spec_text, name, out);
}

}  // namespace

void bind_scenes(py::module_& module) {
  module.def("draw", &draw);
  module.def("generate", &generate);
  module.def("write_scenes", &write_scenes);
  module.def("read_scenes", &read_scenes);
}

}  // namespace ertbench
