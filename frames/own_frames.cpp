#include "frames/own_frames.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/errors.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/border/border_model.h"
#include "forward/sheet/sensor_json.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t looked_at = 1000;  ///< number of frames used by the check
constexpr std::uint64_t block_frames = 1024;
constexpr double least_noise = 5e-4, most_noise = 0.02;  ///< of a frame, relative to the reference

/// Half the sum of the squared steps between successive frames, where they are finite.
double square_of_steps(const Frames& frames) {
  const Eigen::Index steps = frames.rows() - 1;
  const Frames step = frames.bottomRows(steps) - frames.topRows(steps);
  return step.array().isFinite().select(step.array(), 0).square().sum() / 2;
}

/// Mean of frames without contact, read in blocks. Throws InputError for frames unlike the others.
/// `noise` is set to the standard deviation of a channel over the root mean square of the mean,
/// from the steps between successive frames; 0 for one frame.
Frames mean_of_rows(const Sensor& sensor, const FrameSource& source, const ChannelMap& map,
                    std::uint64_t first, std::uint64_t last, double& noise) {
  Frames sum = Frames::Zero(1, static_cast<Eigen::Index>(map.entries.size()));
  double steps = 0;
  double count_of_steps = 0;
  for (std::uint64_t row = first; row <= last; row += block_frames) {
    const std::uint64_t count = std::min(block_frames, last + 1 - row);
    const Frames block = map.apply(source.read(row, count));
    require_quiet(sensor, block, "--background: " + source.files().front().string(), row);
    sum += block.colwise().sum();
    steps += square_of_steps(block);
    count_of_steps += static_cast<double>(block.rows() - 1);
  }
  const Frames mean = sum / static_cast<double>(last + 1 - first);
  const double square = mean.array().isFinite().select(mean.array(), 0).square().sum();
  noise = count_of_steps > 0 && square > 0 ? std::sqrt(steps / count_of_steps / square) : 0;
  return mean;
}

}  // namespace

double relative_noise(const Frames& frames) {
  const double square = frames.colwise().mean().squaredNorm();
  const auto steps = static_cast<double>(frames.rows() - 1);
  return steps > 0 && square > 0 ? std::sqrt(square_of_steps(frames) / steps / square) : 0;
}

std::optional<std::pair<std::uint64_t, std::uint64_t>> rows_of(const std::string& text) {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  const char* const end = text.data() + text.size();
  const auto [dash, error] = std::from_chars(text.data(), end, first);
  if (error != std::errc() || dash == end || (*dash != '-' && *dash != ':')) return std::nullopt;
  const auto [rest, wrong] = std::from_chars(dash + 1, end, last);
  if (wrong != std::errc() || rest != end) return std::nullopt;
  return std::pair(first, last);
}

Sensor sensor_from_file(const fs::path& file) {
  const nlohmann::json content = read_json_file(file);
  const bool is_experiment = content.is_object() && content.contains("datasets");
  if (is_experiment && !content.contains("sensor")) return {};
  if (content.is_object() && content.contains("sensor") && content.at("sensor").is_object()) {
    return sensor_from_json(JsonObject(content.at("sensor"), file.string(), "/sensor"));
  }
  if (content.is_object() && content.contains("sensor") && content.at("sensor").is_string()) {
    return read_sensor(find_sensor_file(content.at("sensor").get<std::string>(), file));
  }
  return read_sensor(file);
}

OwnFrames::OwnFrames(const OwnFramesOptions& options)
    : options_(options), source_(open_frames(options.input, options.file)) {
  if (!options_.calibration.empty()) calibration_ = read_calibration(options_.calibration);
  if (!options_.sensor.empty()) {
    sensor_ = sensor_from_file(options_.sensor);
  } else if (const auto named = source_->sensor()) {
    sensor_ = *named;
  } else if (calibration_) {
    sensor_ = calibration_->declared;
  }
  sensor_ = sensor_of_columns(sensor_, *source_, options_.channels);
  if (calibration_) {
    calibration_ = on_channels_of(*calibration_, sensor_, options_.calibration);
    sensor_.background = calibration_->background;
  }
  declared_ = sensor_;
  map_ = channel_map(sensor_, *source_, options_.channels, options_.unit);
  require_declared_rows();
  take_reference();
  leave_out_channels();
  fit_background();
  if (options_.normalised) normalise();
}

FrameBounds& OwnFrames::bounds() const {
  if (!bounds_) {
    bounds_.emplace(sensor_);
    if (references_.rows() > 1) reference_verdicts_ = bounds_->judge_references(references_);
  }
  return *bounds_;
}

void OwnFrames::require_declared_rows() const {
  const auto rows = static_cast<Eigen::Index>(source_->frames());
  const bool is_table = source_->format() != "eit" && source_->frame_shape().empty();
  const bool is_ours = source_->sensor().has_value();  // files of this program keep frames as rows
  if (!is_table || is_ours || options_.file.transposed.has_value() || rows == 1 ||
      rows != map_.columns)
    return;
  throw InputError(options_.input.string() + ": has " + std::to_string(rows) +
                   " rows and as many columns, and either may be frames; declare --transposed for "
                   "columns or --transposed=false for rows");
}

void OwnFrames::take_reference() {
  const std::string file = options_.input.string();
  if (!options_.background.empty()) {
    references_ = background_rows();
    return;
  }
  const RowMajorMatrix own = source_->reference();
  if (own.rows() > 0) {
    const std::string place = file + ": /reference_voltages: ";
    const auto frames = static_cast<Eigen::Index>(source_->frames());
    const bool fits = own.cols() == map_.columns && (own.rows() == 1 || own.rows() == frames);
    if (!fits) {
      throw InputError(place + "must have shape [" + std::to_string(map_.columns) + "] or [" +
                       std::to_string(frames) + ", " + std::to_string(map_.columns) +
                       "], the order of the frames; has [" + std::to_string(own.rows()) + ", " +
                       std::to_string(own.cols()) + "]");
    }
    references_ = map_.apply(own);
    reference_text_ = "the file's /reference_voltages";
    return;
  }
  if (calibration_) {
    references_ = calibration_->reference.transpose();
    reference_text_ = "of the calibration " + options_.calibration.string();
    return;
  }
  if (!options_.needs_reference) return;
  throw InputError(file + ": /reference_voltages: is missing; give frames without contact by " +
                   "--background, as a file or as rows of this one (0-19)");
}

/// Where the file has its sensor without a background, takes the one that fits the reference.
void OwnFrames::fit_background() {
  if (calibration_ || !options_.sensor.empty() || source_->knows_background() ||
      references_.rows() == 0)
    return;
  const Eigen::RowVectorXd expected = BorderModel(sensor_).reference_voltages().transpose();
  const double level = reference().dot(expected) / expected.squaredNorm();
  if (level > 0) sensor_.background /= level;
}

Frames OwnFrames::background_rows() {
  const auto rows = rows_of(options_.background);
  if (rows) {
    const auto [first, last] = *rows;
    if (first > last || last >= source_->frames()) {
      throw InputError("--background: rows " + options_.background + " are not among the " +
                       std::to_string(source_->frames()) + " of " + options_.input.string() +
                       ", which are counted from 0");
    }
    reference_text_ = "mean of the rows " + options_.background + " of the input";
    return mean_of_rows(sensor_, *source_, map_, first, last, background_noise_);
  }
  const auto other = open_frames(options_.background, options_.file);
  const ChannelMap map = channel_map(declared_, *other, options_.channels, options_.unit);
  reference_text_ =
      "mean of " + std::to_string(other->frames()) + " frames of " + options_.background;
  return mean_of_rows(sensor_, *other, map, 0, other->frames() - 1, background_noise_);
}

std::vector<int> OwnFrames::redundant_zeros() const {
  constexpr int many = 3;  // a third of the channels
  // One frame tells that there are few.
  const std::uint64_t count = many * (voltages(0, 1).array() == 0).count() < sensor_.channels()
                                  ? 1
                                  : std::min(looked_at, frames());
  Frames some(static_cast<Eigen::Index>(count), sensor_.channels());
  for (std::uint64_t i = 0; i < count; ++i) {
    some.row(static_cast<Eigen::Index>(i)) = voltages(i * frames() / count, 1);
  }
  // Electrodes in an order that does not depend on the pairs' directions nor on which one drives.
  const auto measured = [](ChannelElectrodes channel) {
    for (ElectrodePair* pair : {&channel.drive, &channel.measurement}) {
      if (pair->first > pair->second) std::swap(pair->first, pair->second);
    }
    if (channel.drive < channel.measurement) std::swap(channel.drive, channel.measurement);
    return channel;
  };
  const std::vector<ChannelElectrodes> channels = electrodes_of_channels(sensor_);
  std::set<ChannelElectrodes> live;
  std::vector<int> zeros;
  for (Eigen::Index c = 0; c < some.cols(); ++c) {
    if ((some.col(c).array() == 0).all()) {
      zeros.push_back(static_cast<int>(c));
    } else {
      live.insert(measured(channels[static_cast<std::size_t>(c)]));
    }
  }
  std::erase_if(zeros, [&](int c) {
    return !live.contains(measured(channels[static_cast<std::size_t>(c)]));
  });
  if (many * std::ssize(zeros) < some.cols()) zeros.clear();
  return zeros;
}

void OwnFrames::leave_out_channels() {
  const Frames first = voltages(0, 1);
  const auto is_missing = [&](Eigen::Index c) {
    return std::isnan(first(0, c)) || (references_.rows() > 0 && std::isnan(references_(0, c)));
  };
  const std::vector<int> zeros = redundant_zeros();
  for (int c = 0; c < static_cast<int>(first.cols()); ++c) {
    if (!is_missing(c) && !std::binary_search(zeros.begin(), zeros.end(), c)) kept_.push_back(c);
  }
  const Eigen::Index missing = first.cols() - std::ssize(kept_) - std::ssize(zeros);
  if (std::ssize(kept_) == first.cols()) {
    kept_.clear();
    return;
  }
  if (missing > 0) {
    left_out_ = std::to_string(missing) + (missing == 1 ? " channel has no number in any frame"
                                                        : " channels have no number in any frame");
    const std::string electrodes = joined(electrodes_with_bad_channels(sensor_, is_missing));
    if (!electrodes.empty()) left_out_ += " (those of electrode " + electrodes + ", from 0)";
  }
  if (!zeros.empty()) {
    left_out_ += (missing > 0 ? "; " : "") + std::to_string(zeros.size()) +
                 " channels are 0 in every frame, and others measure the same";
  }
  left_out_ += ": they were left out";
  if (kept_.size() < 4) throw InputError(options_.input.string() + ": " + left_out_);
  const std::vector<ChannelElectrodes> all = electrodes_of_channels(declared_);
  std::vector<ChannelElectrodes> channels;
  for (const int c : kept_) channels.push_back(all[static_cast<std::size_t>(c)]);
  sensor_ = with_channels(sensor_, channels);
  map_ = map_.of_channels(kept_);
  if (references_.rows() > 0) references_ = references_(Eigen::all, kept_).eval();
  if (calibration_) calibration_ = on_channels_of(*calibration_, sensor_, options_.calibration);
}

void OwnFrames::normalise() {
  ReferenceVerdict verdict;
  verdict.normalise(reference().transpose(), BorderModel(sensor_).reference_voltages());
  mend(verdict);
  mended_ = false;
}

Eigen::RowVectorXd OwnFrames::reference() const { return median_of_rows(references_); }

Frames OwnFrames::voltages(std::uint64_t first, std::uint64_t count) const {
  return map_.apply(source_->read(first, count));
}

Frames OwnFrames::changes(std::uint64_t first, std::uint64_t count) const {
  Frames frames = voltages(first, count);
  if (references_.rows() > 1) {
    frames -=
        references_.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
  } else {
    frames.rowwise() -= references_.row(0);
  }
  return frames;
}

FrameVerdict OwnFrames::judge(std::uint64_t frame,
                              const Eigen::Ref<const Eigen::RowVectorXd>& change,
                              const FrameReport& said) const {
  const bool own = references_.rows() > 1;
  const auto row = own ? static_cast<Eigen::Index>(frame) : 0;
  FrameVerdict verdict = bounds().judge(change, references_.row(row), said);
  if (own && reference_verdicts_[frame].faults != 0) verdict.faults |= wrong_reference;
  return verdict;
}

ReferenceVerdict OwnFrames::check() {
  const std::uint64_t count = std::min(looked_at, frames());
  Frames some(static_cast<Eigen::Index>(count), sensor_.channels());
  Eigen::Index possible = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t frame = i * frames() / count;
    some.row(possible) = changes(frame, 1);
    if (judge(frame, some.row(possible)).faults == 0) ++possible;
  }
  const Eigen::VectorXd sizes = some.topRows(possible).rowwise().norm();
  const double size = reference().norm();
  if (possible > 0 && size > 0) {
    // A quarter of the frames or more are quiet, or the noise remains unknown.
    const double noise =
        interpolated_quantile(std::vector<double>(sizes.begin(), sizes.end()), 0.25) / size;
    bounds().set_noise(std::clamp(noise, least_noise, most_noise));
  }
  ReferenceVerdict verdict =
      check_reference(sensor_, reference().transpose(), some.topRows(possible));
  bounds().set_dead(verdict.dead);
  if (verdict.unexplained) bounds().set_noise(least_noise);
  const std::vector<std::string> notes = source_->notes();
  verdict.notes.insert(verdict.notes.begin(), notes.begin(), notes.end());
  if (!left_out_.empty()) verdict.notes.insert(verdict.notes.begin(), left_out_);
  return verdict;
}

void OwnFrames::mend(const ReferenceVerdict& verdict) {
  map_ = map_.mended(verdict.from, verdict.factor);
  Frames mended = references_(Eigen::all, verdict.from);
  mended.array().rowwise() *= verdict.factor.transpose().array();
  references_ = std::move(mended);
  mended_ = true;
}

void OwnFrames::fill_reference() {
  const Eigen::VectorXd expected = BorderModel(sensor_).reference_voltages();
  for (auto row : references_.rowwise()) {
    row = filled_reference(sensor_, row.transpose(), expected).transpose();
  }
}

nlohmann::json OwnFrames::description() const {
  const std::string unit = source_->unit();
  const std::vector<fs::path> files = source_->files();
  nlohmann::json names = nlohmann::json::array();
  // A recording of a thousand files is named by its first and last.
  for (const fs::path& file : {files.front(), files.back()}) {
    if (names.empty() || names.back() != printable_path(file.string())) {
      names.push_back(printable_path(file.string()));
    }
  }
  return {{"input",
           {{"files", std::move(names)},
            {"checksum", checksum_of(files)},
            {"format", source_->format()},
            {"dataset", source_->dataset()},
            {"frames", source_->frames()}}},
          {"channels",
           {{"order", printable(map_.order)}, {"columns", map_.columns}, {"left_out", left_out_}}},
          {"difference", options_.normalised ? "normalised" : "absolute"},
          {"unit", options_.unit.empty() ? unit.empty() ? "V" : unit : options_.unit},
          {"mended", mended_},
          {"reference", reference_text_}};
}

std::vector<fs::path> OwnFrames::inputs() const {
  std::vector<fs::path> out = source_->files();
  for (const fs::path& file : {options_.sensor, options_.calibration, fs::path(options_.channels),
                               fs::path(options_.background)}) {
    std::error_code error;
    if (!file.empty() && fs::exists(file, error)) out.push_back(file);
  }
  return out;
}

}  // namespace ertbench
