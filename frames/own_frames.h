#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "forward/sheet/sensor.h"
#include "frames/calibration.h"
#include "frames/channels.h"
#include "frames/frame_bounds.h"
#include "frames/frame_source.h"
#include "frames/reference_check.h"

namespace ertbench {

/// Source and declared format of frames.
struct OwnFramesOptions {
  std::filesystem::path input;
  std::filesystem::path sensor;  ///< empty: the file's own, or d2s if it names none
  std::string channels;          ///< an order (channel_map)
  std::string unit;              ///< "V", "mV" or "uV"
  FrameFileOptions file;
  /// A file of frames like the input, or rows of the input as "first-last", counted from 0 with the
  /// last included; their mean is the reference. Empty: the input's or the calibration's reference.
  std::string background;
  std::filesystem::path calibration;  ///< may be empty
  bool needs_reference = true;        ///< refuse frames without one
  /// Take changes relative to each channel's reference, v / v0, times the model's voltages.
  bool normalised = false;
};

/// Reads the sensor that a JSON file describes itself or as "sensor" of an experiment.
Sensor sensor_from_file(const std::filesystem::path& file);

/// Frames of a file, in V and in the order of the sensor's channels.
class OwnFrames {
 public:
  /// Throws InputError, with the remedy, if the files do not fit together.
  explicit OwnFrames(const OwnFramesOptions& options);

  /// Its background is the calibration's, if there is one. It has no channels that were left out:
  /// those that are NaN in every frame and in a reference, and those that are 0 in every frame if
  /// they are many and others measure the same.
  const Sensor& sensor() const { return sensor_; }
  /// The sensor with all channels, and which of these `sensor` has; empty: all.
  const Sensor& declared_sensor() const { return declared_; }
  const std::vector<int>& kept_channels() const { return kept_; }
  /// What was left out, in words; empty if nothing was.
  const std::string& left_out() const { return left_out_; }
  const std::optional<Calibration>& calibration() const { return calibration_; }
  std::uint64_t frames() const { return source_->frames(); }
  const FrameSource& source() const { return *source_; }
  const ChannelMap& map() const { return map_; }
  /// The reference voltages [channels] V; their median if each frame has its own.
  Eigen::RowVectorXd reference() const;

  /// Standard deviation of a channel in the frames of the background, over the root mean square of
  /// the reference; 0 if there are none, or one.
  double background_noise() const { return background_noise_; }

  Frames voltages(std::uint64_t first, std::uint64_t count) const;  ///< [count, channels] V
  Frames changes(std::uint64_t first, std::uint64_t count) const;   ///< from the reference, V

  /// Judges a frame by its change, and its reference if each frame has its own (FrameBounds).
  FrameVerdict judge(std::uint64_t frame, const Eigen::Ref<const Eigen::RowVectorXd>& change,
                     const FrameReport& said = {}) const;

  /// Compares the reference with the model of the sensor, using up to a thousand frames spread over
  /// the file, without those that `judge` flags; from then on `judge` knows their noise.
  ReferenceVerdict check();
  /// Applies the verdict's mapping to reference and frames from now on.
  void mend(const ReferenceVerdict& verdict);

  /// Electrodes that are dead in the reference already are found from now on (filled_reference).
  void fill_reference();

  /// The provenance that outputs keep: `{"input": {"files", "checksum", "format", "dataset",
  /// "frames"}, "channels": {"order", "columns"}, "unit", "mended", "reference": "..."}`.
  nlohmann::json description() const;
  /// The files of the frames, sensor, order, background and calibration.
  std::vector<std::filesystem::path> inputs() const;

 private:
  void require_declared_rows() const;
  void leave_out_channels();
  /// Channels of `sensor_` that are 0 in every frame where another one, with pairs reversed or
  /// exchanged, is not, if these are many.
  std::vector<int> redundant_zeros() const;
  void normalise();
  void take_reference();
  void fit_background();
  Frames background_rows();
  FrameBounds& bounds() const;

  OwnFramesOptions options_;
  std::unique_ptr<FrameSource> source_;
  std::optional<Calibration> calibration_;
  Sensor sensor_;
  Sensor declared_;
  std::vector<int> kept_;
  std::string left_out_;
  ChannelMap map_;
  Frames references_;  ///< [1, channels] or [frames, channels] V
  double background_noise_ = 0;
  mutable std::optional<FrameBounds> bounds_;  ///< once they are asked for
  mutable std::vector<FrameVerdict>
      reference_verdicts_;  ///< [frames] if each has its own reference
  std::string reference_text_;
  bool mended_ = false;
};

/// Standard deviation of a channel in frames [N, channels] without contact, from the steps between
/// successive ones, over the root mean square of their mean; 0 for one frame.
double relative_noise(const Frames& frames);

/// Parses rows "first-last"; nothing if the text is something else.
std::optional<std::pair<std::uint64_t, std::uint64_t>> rows_of(const std::string& text);

}  // namespace ertbench
