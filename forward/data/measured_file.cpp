#include "forward/data/measured_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {

namespace layout = dataset_layout;
using nlohmann::json;

namespace {

const std::string positions = "/positions_mm";  // [N, 2] from the sheet's centre
const std::string changes = "/changes";         // [N, channels], of presses without a reference
constexpr std::uint64_t most_contacts = 64;

[[noreturn]] void refuse(const Hdf5File& file, const std::string& object,
                         const std::string& message) {
  throw InputError(file.path().string() + ": " + object + ": " + message);
}

std::string text_of(const std::vector<std::uint64_t>& shape) { return "[" + joined(shape) + "]"; }

constexpr double most_apart = 0.25;  ///< of references of frames, relative

/// The row whose norm is the middle one.
Eigen::RowVectorXd middle_row(const RowMajorMatrix& rows) {
  std::vector<std::pair<double, Eigen::Index>> sizes;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) sizes.emplace_back(rows.row(i).norm(), i);
  const auto middle = sizes.begin() + std::ssize(sizes) / 2;
  std::nth_element(sizes.begin(), middle, sizes.end());
  return rows.row(middle->second);
}

/// Channels in any number between different pairs, for a file that does not say which they are.
std::vector<ChannelElectrodes> stand_in_channels(std::uint64_t count, int electrodes) {
  std::vector<ChannelElectrodes> out;
  for (int d = 0; d < electrodes; ++d) {
    const ElectrodePair drive{d, (d + 1) % electrodes};
    const auto driven = [&](int e) { return e == drive.first || e == drive.second; };
    for (int m = 0; m < electrodes; ++m) {
      for (int n = m + 1; n < electrodes && out.size() < count; ++n) {
        if (!driven(m) && !driven(n)) out.push_back({drive, {m, n}});
      }
    }
  }
  return out;
}

/// Shape of the frames of a file of presses.
std::vector<std::uint64_t> shape_of_presses(const Hdf5File& file) {
  const bool are_changes = file.has(changes);
  if ((!are_changes && !file.has(layout::voltages)) || !file.has(positions)) {
    const std::string held = joined(file.names("/"));
    throw InputError(file.path().string() + ": must hold \"changes\" (or \"voltages\") [presses, " +
                     "channels] and \"positions_mm\" [presses, 2]; holds " +
                     (held.empty() ? "nothing" : held));
  }
  const std::string& name = are_changes ? changes : layout::voltages;
  const std::vector<std::uint64_t> shape = file.shape(name);
  if (shape.size() != 2 || shape[1] < 4 || shape[1] > 4096) {
    refuse(file, name, "must have shape [presses, 4 to 4096 channels], got " + text_of(shape));
  }
  file.require_shape(positions, {shape[0], 2});
  return shape;
}

}  // namespace

MeasuredFile::MeasuredFile(const std::filesystem::path& file, const Sensor& sensor)
    : file_(Hdf5File::open(file)) {
  check_shapes(static_cast<std::uint64_t>(sensor.channels()));
  truth_ = {file_.has(layout::conductivity), true};
  if (truth_.images) {
    const PixelGrid pixels = sensor.image();
    file_.require_shape(layout::conductivity, {size_, static_cast<std::uint64_t>(pixels.rows()),
                                               static_cast<std::uint64_t>(pixels.columns())});
  }
  if (file_.has(layout::contacts)) {
    const std::vector<std::uint64_t> shape = file_.require_shape(layout::contacts, {size_, 0, 0});
    contacts_ = shape[1];
    columns_ = shape[2];
    const bool known = (columns_ >= 2 && columns_ <= 4) || columns_ == layout::contact_columns;
    if (!known || contacts_ > most_contacts) {
      refuse(file_, layout::contacts,
             "must have shape [frames, at most " + std::to_string(most_contacts) +
                 " contacts, 2 to 4]: x, y and radius in mm, conductivity ratio; or the 7 columns "
                 "of generated sets; got " +
                 text_of(shape));
    }
    if (columns_ >= 4) truth_.images = true;
  } else if (file_.has(positions)) {
    file_.require_shape(positions, {size_, 2});
  } else {
    truth_.places = false;
  }
}

void MeasuredFile::check_shapes(std::uint64_t channels) {
  without_reference_ =
      file_.has(positions) && (file_.has(changes) || !file_.has(layout::reference_voltages));
  const std::string& name = file_.has(changes) ? changes : layout::voltages;
  const std::vector<std::uint64_t> frames = file_.shape(name);
  if (frames.size() != 2 || frames[0] == 0 || frames[1] != channels) {
    refuse(file_, name,
           "must have shape [frames, " + std::to_string(channels) +
               "], the channels of the experiment's sensor, got " + text_of(frames) +
               "; describe the sensor that measured them in \"sensor\"");
  }
  size_ = frames[0];
  if (without_reference_) return;
  const std::vector<std::uint64_t> reference = file_.shape(layout::reference_voltages);
  own_references_ = reference.size() == 2;
  if (reference != (own_references_ ? std::vector{size_, channels} : std::vector{channels})) {
    refuse(file_, layout::reference_voltages,
           "must have shape [" + std::to_string(channels) + "] or [" + std::to_string(size_) +
               ", " + std::to_string(channels) + "], one for each frame, got " +
               text_of(reference));
  }
}

RowMajorMatrix MeasuredFile::positions_mm() const {
  RowMajorMatrix out = file_.read_rows(positions, 0, size_);
  if (without_reference_) {
    const Eigen::RowVectorXd low = out.colwise().minCoeff();
    out.rowwise() -= (low + out.colwise().maxCoeff()) / 2;
  }
  return out;
}

void MeasuredFile::read_changes(const std::vector<std::uint64_t>& rows, Content& out) const {
  const bool are_changes = file_.has(changes);
  const RowMajorMatrix all =
      file_.read_rows(are_changes ? changes : layout::voltages, 0, size_, true);
  out.reference = Eigen::VectorXd::Zero(all.cols());
  for (Eigen::Index c = 0; c < all.cols() && !are_changes; ++c) {
    std::vector<double> values(all.col(c).begin(), all.col(c).end());
    std::erase_if(values, [](double value) { return !std::isfinite(value); });
    if (values.empty()) continue;
    const auto middle = values.begin() + std::ssize(values) / 2;
    std::nth_element(values.begin(), middle, values.end());
    out.reference[c] = *middle;
  }
  out.voltages.resize(std::ssize(rows), all.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = all.row(static_cast<Eigen::Index>(rows[i]));
    if (!row.array().isFinite().any()) {
      refuse(file_, are_changes ? changes : layout::voltages,
             "row " + std::to_string(rows[i]) + " has no value; leave such presses out");
    }
    out.voltages.row(static_cast<Eigen::Index>(i)) =
        row.array().isFinite().select(row, out.reference.transpose());
  }
}

RowMajorMatrix MeasuredFile::rows_of(const std::string& dataset,
                                     const std::vector<std::uint64_t>& rows, bool allow_nan) const {
  const auto [least, most] = std::minmax_element(rows.begin(), rows.end());
  const RowMajorMatrix all = file_.read_rows(dataset, *least, *most - *least + 1, allow_nan);
  RowMajorMatrix out(static_cast<Eigen::Index>(rows.size()), all.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out.row(static_cast<Eigen::Index>(i)) = all.row(static_cast<Eigen::Index>(rows[i] - *least));
  }
  return out;
}

Scene MeasuredFile::scene_of(const MeasuredFrames& frames, const Sensor& sensor, double strength,
                             const Eigen::Ref<const Eigen::RowVectorXd>& values) const {
  const double unit = sensor.sheet->unit_mm();
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  const double declared = 1 - (1 - frames.conductivity_ratio) * strength;
  if (columns_ == layout::contact_columns) {
    Scene scene;
    for (std::uint64_t k = 0; k < contacts_; ++k) {
      Eigen::RowVectorXd row = values.segment(
          static_cast<Eigen::Index>(k) * layout::contact_columns, layout::contact_columns);
      if (row[0] == static_cast<double>(Shape::polygon)) {  // its corners are not kept
        row[0] = static_cast<double>(Shape::disc);
        row.segment<2>(3).setConstant(frames.radius_mm / unit);
        row[5] = 0;
      }
      for (Contact& contact : layout::unpack(row, Eigen::RowVectorXd()).contacts) {
        scene.contacts.push_back(std::move(contact));
      }
    }
    return scene;
  }
  Scene scene;
  const Eigen::Index columns = columns_ == 0 ? 2 : static_cast<Eigen::Index>(columns_);
  for (Eigen::Index k = 0; k + columns <= values.size(); k += columns) {
    if (!std::isfinite(values[k])) continue;  // no such contact in this frame
    Contact contact;
    contact.centre = middle + values.segment<2>(k).transpose() / unit;
    contact.half_size.setConstant((columns > 2 ? values[k + 2] : frames.radius_mm) / unit);
    contact.conductivity_ratio = columns > 3 ? values[k + 3] : declared;
    scene.contacts.push_back(std::move(contact));
  }
  return scene;
}

std::vector<Scene> MeasuredFile::scenes_of(const MeasuredFrames& frames, const Sensor& sensor,
                                           const std::vector<std::uint64_t>& rows) const {
  std::vector<Scene> scenes(rows.size());
  if (!truth_.places) return scenes;
  const std::string& dataset = columns_ == 0 ? positions : layout::contacts;
  const std::vector<Eigen::Index> at(rows.begin(), rows.end());
  const RowMajorMatrix values =
      columns_ == 0 ? RowMajorMatrix(positions_mm()(at, Eigen::all)) : rows_of(dataset, rows, true);
  Eigen::VectorXd strength = Eigen::VectorXd::Ones(values.rows());
  if (!frames.strength_of.empty()) {
    file_.require_shape(frames.strength_of, {size_});
    strength = rows_of(frames.strength_of, rows).col(0) / frames.full_strength;
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    scenes[i] = scene_of(frames, sensor, strength[row], values.row(row));
    const std::string place = "row " + std::to_string(rows[i]);
    for (const Contact& contact : scenes[i].contacts) {
      if (!contact.centre.allFinite() || sensor.sheet->depth(contact.centre) < 0) {
        refuse(file_, dataset, place + " lies off the sheet; places are in mm from its centre");
      }
      const bool sized = contact.half_size.minCoeff() >= contact_lengths[0] &&
                         contact.half_size.maxCoeff() <= contact_lengths[1];
      if (!sized) refuse(file_, dataset, place + " has a size that no contact can have");
      if (!(contact.conductivity_ratio >= conductivity_ratios[0] &&
            contact.conductivity_ratio <= conductivity_ratios[1])) {
        refuse(file_, columns_ > 3 ? dataset : frames.strength_of,
               place + " gives a conductivity ratio of " +
                   std::to_string(contact.conductivity_ratio) +
                   "; it must be > 0, so that \"full\" is not far below the largest strength");
      }
    }
  }
  return scenes;
}

MeasuredFile::Content MeasuredFile::read(const MeasuredFrames& frames, const Sensor& sensor,
                                         const std::vector<std::uint64_t>& rows) const {
  Content out;
  if (without_reference_) {
    read_changes(rows, out);
    out.voltages *= frames.scale;
    out.reference *= frames.scale;
  } else if (own_references_) {
    out.voltages = frames.scale * rows_of(layout::voltages, rows);
    const RowMajorMatrix references = frames.scale * rows_of(layout::reference_voltages, rows);
    out.reference = references.colwise().mean().transpose();
    const Eigen::RowVectorXd usual = middle_row(references);
    for (Eigen::Index i = 0; i < references.rows(); ++i) {
      if ((references.row(i) - usual).norm() <= most_apart * usual.norm()) continue;
      refuse(file_, layout::reference_voltages,
             "row " + std::to_string(rows[static_cast<std::size_t>(i)]) +
                 " is unlike the other frames' references; leave such frames out");
    }
    out.voltages = (out.voltages - references).rowwise() + out.reference.transpose();
  } else {
    out.voltages = frames.scale * rows_of(layout::voltages, rows);
    out.reference = frames.scale * file_.read_vector(layout::reference_voltages);
  }
  out.scenes = scenes_of(frames, sensor, rows);
  if (file_.has(layout::conductivity)) {
    out.conductivity = rows_of(layout::conductivity, rows);
    if (out.conductivity.minCoeff() <= 0) {
      refuse(file_, layout::conductivity,
             "must be > 0 S/m everywhere; images are conductivities, not their changes");
    }
    return out;
  }
  const PixelGrid pixels = sensor.image();
  out.conductivity.resize(out.voltages.rows(), pixels.count());
  Eigen::VectorXd image(pixels.count());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rasterise(out.scenes[i], pixels, Rasterisation::area, image);
    out.conductivity.row(static_cast<Eigen::Index>(i)) = sensor.background * image;
  }
  return out;
}

json inspected(const std::filesystem::path& file, const std::function<json()>& look) {
  constexpr double time_limit_s = 600;
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        json said;
        try {
          said = look();
        } catch (const InputError& wrong) {
          said = {{"refused", printable(wrong.what())}};
        }
        send(said.dump());
      },
      {time_limit_s, machine_memory_bytes() / 2});
  if (!outcome.finished || outcome.messages.empty()) {
    throw InputError(file.string() +
                     ": is damaged: the HDF5 library cannot get through it; write it again");
  }
  json said = json::parse(outcome.messages.back());
  if (said.contains("refused")) throw InputError(said.at("refused").get<std::string>());
  return said;
}

Sensor sensor_of_presses(const std::filesystem::path& file) {
  constexpr int electrodes = 32;
  constexpr double margin = 1.1;  // of the sheet's radius, over that of the presses
  const auto disc = [&](double diameter_mm, std::uint64_t channels) {
    const json sensor = {
        {"shape", "disc"}, {"diameter_mm", diameter_mm}, {"electrode_count", electrodes}};
    return with_channels(sensor_from_json(JsonObject(sensor, file.string(), "")),
                         stand_in_channels(channels, electrodes));
  };
  const json said = inspected(file, [&]() -> json {
    const std::uint64_t channels = shape_of_presses(Hdf5File::open(file))[1];
    const RowMajorMatrix places = MeasuredFile(file, disc(100, channels)).positions_mm();
    return {channels, places.rowwise().norm().maxCoeff()};
  });
  const double farthest = said.at(1).get<double>();
  if (!(farthest > 0)) {
    throw InputError(file.string() + ": " + positions + ": all presses are at one place");
  }
  return disc(2 * margin * farthest, said.at(0).get<std::uint64_t>());
}

MeasuredBlocks::MeasuredBlocks(const DatasetSpec& spec) : spec_(spec) {
  const MeasuredFrames& frames = *spec.measured();
  if (hash_of_file(frames.file) != frames.checksum) {
    throw InputError(frames.file.string() + ": has changed since the experiment was read");
  }
  content_ = MeasuredFile(frames.file, spec.sensor).read(frames, spec.sensor, frames.rows());
}

DatasetBlock MeasuredBlocks::block(std::uint64_t first, std::uint64_t count) const {
  const auto from = static_cast<Eigen::Index>(first);
  const auto rows = static_cast<Eigen::Index>(count);
  DatasetBlock block;
  block.clean_voltages = content_.voltages.middleRows(from, rows);
  block.voltages = block.clean_voltages;
  block.conductivity = content_.conductivity.middleRows(from, rows);
  block.contacts.resize(
      rows, static_cast<Eigen::Index>(layout::contact_width(spec_)) * layout::contact_columns);
  block.vertices.resize(rows, 0);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const std::uint64_t index = first + static_cast<std::uint64_t>(i);
    block.truths.push_back(content_.scenes[index]);
    layout::pack(block.truths.back(), block.contacts.row(i), block.vertices.row(i));
  }
  return block;
}

}  // namespace ertbench
