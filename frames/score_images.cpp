#include "frames/score_images.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <span>

#include "bench/plot/image_panel.h"
#include "bench/score/image_contacts.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "frames/own_frames.h"
#include "frames/reconstruct.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
namespace layout = dataset_layout;

constexpr std::string_view titles = "frame,status,reason,";
constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";

bool begins_with(const fs::path& file, std::string_view text) {
  std::ifstream in(file, std::ios::binary);
  std::string begin(text.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return in && begin == text;
}

void append_number(std::string& text, double value) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  if (error == std::errc()) text.append(digits, end);
}

constexpr std::uint64_t block = 256;

Sensor sensor_of_truth(const ScoreOptions& options, const Hdf5File& truth, const Hdf5File& images) {
  if (!options.sensor.empty()) return sensor_from_file(options.sensor);
  return sensor_of(truth.has_attribute("/", "sensor") ? truth : images);
}

/// [N, rows, columns] or [N, pixels].
std::uint64_t require_images(const Hdf5File& file, const std::string& dataset,
                             const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  const auto rows = static_cast<std::uint64_t>(pixels.rows());
  const auto columns = static_cast<std::uint64_t>(pixels.columns());
  if (file.shape(dataset).size() == 2) return file.require_shape(dataset, {0, rows * columns})[0];
  return file.require_shape(dataset, {0, rows, columns})[0];
}

/// The regions of a true image as discs of equal area.
Scene scene_of_image(const Sensor& sensor, ContactReader& reader,
                     const Eigen::RowVectorXd& true_change) {
  constexpr double rounding = 1e-9;  // of a file's numbers; no contact
  Scene scene;
  if (true_change.cwiseAbs().maxCoeff() <= rounding * sensor.background) return scene;
  std::vector<FoundContact> regions;
  reader.read({}, true_change, regions);
  for (const FoundContact& region : regions) {
    Contact disc;
    disc.centre = region.place;
    disc.half_size.setConstant(std::sqrt(region.area / std::numbers::pi));
    disc.conductivity_ratio =
        std::clamp(1 - region.peak / sensor.background, conductivity_ratios[0], 1.0);
    scene.contacts.push_back(disc);
  }
  return scene;
}

/// What images have in common with their truths that tells of another unit, sign or orientation.
class ImageLikeness {
 public:
  explicit ImageLikeness(const Sensor& sensor) : sensor_(sensor), pixels_(sensor.image()) {}

  /// Both [pixels], changes in S/m.
  void add(std::uint64_t frame, const Eigen::RowVectorXd& image, const Eigen::RowVectorXd& truth) {
    const double sizes = image.norm() * truth.norm();
    if (!(truth.norm() > 0) || !(image.norm() > 0)) return;
    const double scale = image.norm() / truth.norm();
    scales_.push_back(scale);
    if (scale > far) far_.push_back(frame);
    levels_.push_back(median(std::vector<double>(image.begin(), image.end())) / sensor_.background);
    const auto there =
        Eigen::Map<const RowMajorMatrix>(truth.data(), pixels_.rows(), pixels_.columns());
    const auto here =
        Eigen::Map<const RowMajorMatrix>(image.data(), pixels_.rows(), pixels_.columns());
    const auto like = [&](const RowMajorMatrix& other) {
      return other.size() == here.size() && other.rows() == here.rows()
                 ? here.cwiseProduct(other).sum() / sizes
                 : 0;
    };
    turned_[0] += like(there);
    turned_[1] += like(there.colwise().reverse());
    turned_[2] += like(there.rowwise().reverse());
    turned_[3] += like(there.reverse());
    turned_[4] += like(there.transpose());
    turned_[5] += like(there.transpose().colwise().reverse());
    turned_[6] += like(there.transpose().rowwise().reverse());
    turned_[7] += like(there.transpose().reverse());
  }

  std::vector<std::string> notes() const {
    std::vector<std::string> out;
    if (scales_.empty()) return out;
    const auto count = static_cast<double>(scales_.size());
    const double as_is = turned_[0] / count;
    const auto* const best = std::ranges::max_element(turned_);
    if (-as_is > clearly) {
      out.emplace_back("the images have the opposite sign of the truths");
    } else if (*best / count > as_is + clearly) {
      out.push_back(std::string("the images fit the truths much better ") +
                    ways[best - turned_.begin()] +
                    "; row 0 is at the least y, column 0 at the least x");
    }
    const double usual = median(scales_);
    if (usual > far || usual < 1 / far) {
      out.push_back("the images are " + number_text(usual) +
                    " times as strong as the truths, in the median: must be S/m");
    } else if (!far_.empty()) {
      const auto listed = std::span(far_).first(std::min<std::size_t>(far_.size(), 8));
      out.push_back(std::to_string(far_.size()) + " images are more than " + number_text(far) +
                    " times as strong as their truths: frames " + joined(listed));
    }
    if (std::abs(median(levels_)) > 0.5) {
      out.push_back("most pixels of the images are " + number_text(median(levels_)) +
                    " times the background: are they conductivities and no changes?");
    }
    return out;
  }

 private:
  static constexpr double clearly = 0.3;  ///< of the correlation
  static constexpr double far = 30;       ///< factor
  static constexpr const char* ways[] = {"",
                                         "with their rows turned round",
                                         "with their columns turned round",
                                         "turned by 180 degrees",
                                         "with rows and columns exchanged",
                                         "turned by 90 degrees",
                                         "turned by 90 degrees",
                                         "mirrored at the other diagonal"};

  Sensor sensor_;
  PixelGrid pixels_;
  std::vector<double> scales_, levels_;
  std::vector<std::uint64_t> far_;
  std::array<double, 8> turned_{};  ///< sums of correlations
};

class ScoredFiles {
 public:
  explicit ScoredFiles(const ScoreOptions& options)
      : truth_(Hdf5File::open(options.truth)),
        images_(Hdf5File::open(options.images)),
        sensor_(sensor_of_truth(options, truth_, images_)),
        dataset_(options.dataset),
        named_(!options.sensor.empty() || truth_.has_attribute("/", "sensor") ||
               images_.has_attribute("/", "sensor")) {
    if (dataset_.empty()) {
      dataset_ = images_.has("/conductivity_change") ? "/conductivity_change" : "/conductivity";
    }
    if (!dataset_.starts_with('/')) dataset_.insert(0, "/");
    is_absolute_ = dataset_ == layout::conductivity;
    require_one_sensor(options);
    frames_ = require_images(truth_, layout::conductivity, sensor_);
    const std::uint64_t there = require_images(images_, dataset_, sensor_);
    if (there != frames_) {
      throw InputError(options.images.string() + ": " + dataset_ + ": holds " +
                       std::to_string(there) + " images, " + options.truth.string() + " " +
                       std::to_string(frames_) + "; the two must belong together, row by row");
    }
    if (images_.has("/status")) images_.require_shape("/status", {frames_});
    if (truth_.has(layout::contacts)) {
      truth_.require_shape(layout::contacts, {frames_, 0, layout::contact_columns});
    }
  }

  ImageScores score() const {
    ImageScores out;
    out.frames = static_cast<int>(frames_);
    const bool has_contacts = truth_.has(layout::contacts);
    out.contacts = has_contacts ? "contacts of the file" : "regions of the true images";
    ContactReader reader(sensor_);
    ImageLikeness likeness(sensor_);
    std::vector<FrameMetrics> metrics;
    for (std::uint64_t first = 0; first < frames_; first += block) {
      const std::uint64_t count = std::min(block, frames_ - first);
      const Images truths = truth_.read_rows(layout::conductivity, first, count);
      Images changes = images_.read_rows(dataset_, first, count, true);
      if (is_absolute_) changes.array() -= sensor_.background;
      RowMajorMatrix status = RowMajorMatrix::Zero(changes.rows(), 1);
      if (images_.has("/status")) status = images_.read_rows("/status", first, count);
      require_sense(first, truths, status);
      const std::vector<Scene> scenes =
          has_contacts ? layout::read_scenes(truth_, first, count) : std::vector<Scene>{};
      for (Eigen::Index i = 0; i < changes.rows(); ++i) {
        const Eigen::RowVectorXd truth = truths.row(i);
        const bool usable = changes.row(i).allFinite() &&
                            status(i, 0) != static_cast<double>(FrameStatus::undefined);
        out.undefined_frames += !usable;
        out.flagged_frames += usable && status(i, 0) == static_cast<double>(FrameStatus::suspect);
        if (!usable) {
          metrics.emplace_back();
          continue;
        }
        const Scene scene =
            has_contacts ? scenes[static_cast<std::size_t>(i)]
                         : scene_of_image(sensor_, reader, truth.array() - sensor_.background);
        metrics.push_back(frame_metrics(sensor_, truth, changes.row(i), scene));
        likeness.add(first + static_cast<std::uint64_t>(i), changes.row(i),
                     truth.array() - sensor_.background);
      }
    }
    out.metrics = summarise(metrics);
    out.notes = likeness.notes();
    return out;
  }

 private:
  /// Refuses images of another sheet, other electrodes or a background that is a quarter off.
  void require_one_sensor(const ScoreOptions& options) const {
    if (!images_.has_attribute("/", "sensor")) return;
    const nlohmann::json expected = to_json(sensor_);
    const nlohmann::json found = to_json(sensor_of(images_));
    nlohmann::json either = found;  // the keys of both
    either.update(expected);
    for (const auto& [key, unused] : either.items()) {
      const nlohmann::json value = expected.value(key, nlohmann::json());
      const nlohmann::json other = found.value(key, nlohmann::json());
      const bool near = key == "background" && other < 1.25 * value.get<double>() &&
                        other > value.get<double>() / 1.25;
      if (other == value || near) continue;
      throw InputError(options.images.string() + ": its sensor has \"" + key + "\" " +
                       json_text(other) + ", that of " +
                       (options.sensor.empty() ? options.truth : options.sensor).string() + " " +
                       json_text(value) + "; name the images' own truth");
    }
  }

  /// Refuses values that cannot be what they should.
  void require_sense(std::uint64_t first, const Images& truths,
                     const RowMajorMatrix& status) const {
    constexpr double most = 10;       // the median pixel over the background, or its reciprocal
    constexpr double uniform = 1e-6;  // relative range of an image without contact
    const auto fail = [&](const Hdf5File& file, const std::string& dataset, Eigen::Index row,
                          const std::string& what) {
      throw InputError(file.path().string() + ": " + dataset + ": frame " +
                       std::to_string(first + static_cast<std::uint64_t>(row)) + " " + what);
    };
    const std::string background =
        number_text(sensor_.background) + " S/m, the background of the sensor";
    std::vector<double> medians;
    for (Eigen::Index i = 0; i < truths.rows(); ++i) {
      const double least = truths.row(i).minCoeff();
      if (least < 0) {
        fail(truth_, layout::conductivity, i,
             "has the conductivity " + number_text(least) + " S/m; it cannot be negative");
      }
      const double usual = median(std::vector<double>(truths.row(i).begin(), truths.row(i).end()));
      medians.push_back(usual);
      const bool far = usual > most * sensor_.background || most * usual < sensor_.background;
      const bool other = truths.row(i).maxCoeff() - least <= uniform * usual &&
                         std::abs(usual - sensor_.background) > 0.01 * sensor_.background;
      if (far || other) {
        fail(truth_, layout::conductivity, i,
             (far ? "has the median " : "is uniform at ") + number_text(usual) + " S/m, not " +
                 background + "; conductivities must be in S/m, of this sensor");
      }
      const double s = status(i, 0);
      if (s < 0 || s > static_cast<double>(FrameStatus::suspect) || s != std::floor(s)) {
        fail(images_, "/status", i,
             "has the status " + number_text(s) + "; it must be 0, 1, 2 or 3");
      }
    }
    const double all = median(medians);
    if (!named_ && first == 0 && std::abs(all / sensor_.background - 1) > 0.05) {
      throw InputError(truth_.path().string() + ": " + layout::conductivity + ": has the median " +
                       number_text(all) + " S/m, not " + background +
                       " that is assumed; name yours by --sensor");
    }
  }

  Hdf5File truth_;
  Hdf5File images_;
  Sensor sensor_;
  std::string dataset_;
  bool named_ = false;  ///< a file says the sensor
  bool is_absolute_ = false;
  std::uint64_t frames_ = 0;
};

}  // namespace

void require_table_of_images(const fs::path& file, const std::vector<fs::path>& inputs) {
  require_output(file, inputs, {"table of images (CSV)", [](const fs::path& there) {
                                  return begins_with(there, titles);
                                }});
}

void require_picture(const fs::path& file, const std::vector<fs::path>& inputs) {
  if (file.extension() != ".png") {
    throw InputError("--png: must end in .png, got " + file.string());
  }
  require_output(file, inputs, {"picture (PNG)", [](const fs::path& there) {
                                  return begins_with(there, png_signature);
                                }});
  fs::path beside = file;
  beside.replace_extension(".svg");
  require_output(beside, inputs, {"picture (SVG)", [](const fs::path& there) {
                                    return begins_with(there, "<?xml") ||
                                           begins_with(there, "<svg");
                                  }});
}

void write_table_of_images(const fs::path& images, const fs::path& file) {
  const Hdf5File in = Hdf5File::open(images);
  const std::vector<std::uint64_t> shape = in.require_shape("/conductivity_change", {0, 0, 0});
  replace_file(file, [&](const fs::path& place) {
    std::ofstream out(place, std::ios::binary);
    std::string text(titles);
    for (std::uint64_t row = 0; row < shape[1]; ++row) {
      for (std::uint64_t column = 0; column < shape[2]; ++column) {
        if (row + column > 0) text += ',';
        text += 'r';
        append_number(text, static_cast<double>(row));
        text += 'c';
        append_number(text, static_cast<double>(column));
      }
    }
    text += '\n';
    for (std::uint64_t frame = 0; frame < shape[0]; ++frame) {
      const RowMajorMatrix image = in.read_rows("/conductivity_change", frame, 1, true);
      append_number(text, static_cast<double>(frame));
      for (const char* what : {"/status", "/reason"}) {
        text += ',';
        append_number(text, in.read_rows(what, frame, 1)(0, 0));
      }
      for (const double value : image.reshaped<Eigen::RowMajor>()) {
        text += ',';
        if (std::isfinite(value)) append_number(text, value);
      }
      text += '\n';
      out << text;
      text.clear();
    }
    out.close();
    if (!out) throw InputError(file.string() + ": cannot be written; is the disk full?");
  });
}

void draw_images(const fs::path& images, const std::vector<std::uint64_t>& frames,
                 const fs::path& file) {
  const Hdf5File in = Hdf5File::open(images);
  const std::uint64_t there = in.require_shape("/conductivity_change", {0, 0, 0})[0];
  std::vector<std::uint64_t> shown = frames;
  if (shown.empty()) {
    const std::uint64_t count = std::min<std::uint64_t>(there, most_pictured);
    for (std::uint64_t i = 0; i < count; ++i) {
      shown.push_back(count > 1 ? i * (there - 1) / (count - 1) : 0);
    }
  }
  const Sensor sensor = sensor_of(in);
  Images pictures(static_cast<Eigen::Index>(shown.size()), sensor.pixels());
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    if (shown[i] >= there) {
      throw InputError("--png-frames: there is no frame " + std::to_string(shown[i]) + "; the " +
                       std::to_string(there) + " frames are counted from 0");
    }
    pictures.row(static_cast<Eigen::Index>(i)) =
        in.read_rows("/conductivity_change", shown[i], 1, true).row(0);
    labels.push_back("frame " + std::to_string(shown[i]));
  }
  fs::path stem = file;
  stem.replace_extension();
  draw_images_figure(sensor, pictures, labels, stem);
}

ImageScores score_images(const ScoreOptions& options) {
  survive_reading(options.truth, [&] {
    const Hdf5File truth = Hdf5File::open(options.truth);
    const std::uint64_t rows = truth.shape(layout::conductivity).at(0);
    for (std::uint64_t r = 0; r < rows; r += block) {
      truth.read_rows(layout::conductivity, r, std::min(block, rows - r), true);
    }
  });
  // Read both files once in a child process.
  survive_reading(options.images, [&] { ScoredFiles(options).score(); });
  return ScoredFiles(options).score();
}

nlohmann::json to_json(const ImageScores& scores) {
  nlohmann::json metrics;
  for (const Metric metric : kMetrics) {
    const MetricSummary& summary = scores.metrics[metric];
    nlohmann::json& out = metrics[name_of(metric)];
    out = {{"title", axis_title(metric)}, {"mean", or_null(summary.mean)},
           {"ci95", nlohmann::json()},    {"median", or_null(summary.median)},
           {"count", summary.count},      {"undefined", summary.undefined}};
    if (summary.ci95) out["ci95"] = {summary.ci95->low, summary.ci95->high};
  }
  return {{"schema", 1},
          {"frames", scores.frames},
          {"undefined_frames", scores.undefined_frames},
          {"flagged_frames", scores.flagged_frames},
          {"contacts", scores.contacts},
          {"notes", scores.notes},
          {"metrics", std::move(metrics)}};
}

}  // namespace ertbench
