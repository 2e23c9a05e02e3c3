#include <nlohmann/json.hpp>

#include "bench/score/metrics.h"
#include "core/files.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "frames/own_frames.h"
#include "python/module/arrays.h"

namespace ertbench {
namespace {

/// Frames of a file: their changes, their reference and the verdict on it.
py::dict read_frames(const std::string& input, const Sensor* sensor, const std::string& unit,
                     const std::string& channels, const std::string& dataset, bool transposed,
                     const std::string& background, bool fix, bool force) {
  const Hdf5Turn turn;
  const TemporaryFolder folder("python");
  OwnFramesOptions options;
  options.input = input;
  options.unit = unit;
  options.channels = channels;
  options.file = {dataset, transposed};
  options.background = background;
  if (sensor) {
    options.sensor = folder / "sensor.json";
    write_file_atomically(options.sensor, json_text(to_json(*sensor)));
  }
  OwnFrames frames(options);
  using State = ReferenceVerdict::State;
  const ReferenceVerdict verdict = frames.check();
  if (verdict.state == State::mendable && fix) {
    frames.mend(verdict);
  } else if (verdict.state != State::sound && !force) {
    throw InputError(input + ": " + verdict.text() + "\n  nothing was read; " +
                     (verdict.state == State::mendable ? "fix=True reads the frames so, " : "") +
                     "force=True takes them as they are");
  }
  frames.fill_reference();
  const auto count = static_cast<py::ssize_t>(frames.frames());
  const py::ssize_t width = frames.sensor().channels();
  py::dict out;
  out["sensor"] = frames.sensor();
  out["changes"] = array_of(frames.changes(0, frames.frames()), {count, width});
  out["voltages"] = array_of(frames.voltages(0, frames.frames()), {count, width});
  out["reference"] = array_of(frames.reference(), {width});
  out["verdict"] = verdict.text();
  return out;
}

/// Scores images [N, pixels] against truths [N, pixels] and the contacts of a set, which may be
/// None: one array [N] for each metric, NaN where it is undefined.
py::dict score(const Sensor& sensor, const py::object& images, const py::object& truths,
               const py::object& contacts, const py::object& vertices, int threads) {
  const std::vector<py::ssize_t> shape = {sensor.image_rows(), sensor.image_columns()};
  const Rows estimated = rows_of(images, "images", shape, "S/m", false);
  const Rows known = rows_of(truths, "truth", shape, "S/m");
  if (estimated.count != known.count) {
    throw InputError("images: must be as many as the truth's " + std::to_string(known.count) +
                     ", got " + std::to_string(estimated.count));
  }
  std::vector<Scene> scenes(static_cast<std::size_t>(known.count));
  const Truth truth{true, !contacts.is_none()};
  if (truth.places) {
    const Array rows = numbers_of(contacts, "contacts", false);
    const Array corners = numbers_of(vertices, "vertices", false);
    if (rows.ndim() != 3 || rows.shape(0) != known.count || corners.shape(0) != known.count) {
      throw InputError("contacts: must be those of the truth's images");
    }
    const RowsView contact_rows(rows.data(), known.count, rows.shape(1) * rows.shape(2));
    const RowsView corner_rows(corners.data(), known.count, corners.size() / known.count);
    for (Eigen::Index i = 0; i < known.count; ++i) {
      scenes[static_cast<std::size_t>(i)] =
          dataset_layout::unpack(contact_rows.row(i), corner_rows.row(i));
    }
  }
  RowMajorMatrix values = RowMajorMatrix::Constant(static_cast<Eigen::Index>(kMetrics.size()),
                                                   known.count, std::nan(""));
  for_blocks(known.count, 16, threads, [&](auto begin, auto end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      if (!estimated.view().row(i).allFinite()) continue;
      const FrameMetrics metrics =
          frame_metrics(sensor, known.view().row(i), estimated.view().row(i),
                        scenes[static_cast<std::size_t>(i)]);
      for (std::size_t m = 0; m < kMetrics.size(); ++m) {
        values(static_cast<Eigen::Index>(m), i) = metrics[kMetrics[m]].value_or(std::nan(""));
      }
    }
  });
  py::dict out;
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    if (!is_known(kMetrics[m], truth)) continue;
    out[name_of(kMetrics[m])] = array_of(values.row(static_cast<Eigen::Index>(m)), {known.count});
  }
  return out;
}

/// (mean, (low, high), median, frames with a value, without); None where there is none.
py::tuple summary(const py::object& values, const std::string& metric) {
  const Array numbers = numbers_of(values, "values", false);
  std::vector<std::optional<double>> some;
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    const double value = numbers.data()[i];
    some.push_back(std::isfinite(value) ? std::optional(value) : std::nullopt);
  }
  const MetricSummary all = summarise(some, first_name_of(metric_from_name(metric)));
  const auto number = [](const std::optional<double>& value) {
    return value ? py::object(py::float_(*value)) : py::object(py::none());
  };
  const py::object interval =
      all.ci95 ? py::object(py::make_tuple(all.ci95->low, all.ci95->high)) : py::object(py::none());
  return py::make_tuple(number(all.mean), interval, number(all.median), all.count, all.undefined);
}

}  // namespace

void bind_frames(py::module_& module) {
  module.def("read_frames", &read_frames);
  module.def("score", &score);
  module.def("summary", &summary);
  py::dict legends;
  for (const Metric metric : kMetrics) legends[name_of(metric)] = entry_of(metric).legend;
  module.attr("metrics") = legends;
}

}  // namespace ertbench
