#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "forward/sheet/sensor.h"
#include "frames/calibration.h"
#include "frames/channels.h"
#include "frames/frame_source.h"
#include "frames/reference_check.h"

namespace ertbench {

/// Where frames come from and how they are declared.
struct OwnFramesOptions {
  std::filesystem::path input;
  std::filesystem::path sensor;  ///< empty: the file's own, d2s where it names none
  std::string channels;          ///< an order (channel_map)
  std::string unit;              ///< "V", "mV" or "uV"
  FrameFileOptions file;
  /// A file of frames like the input, or rows of the input as "first-last", counted from 0, the
  /// last one included; their mean is the reference. Empty: what the input or the calibration says.
  std::string background;
  std::filesystem::path calibration;  ///< may be empty
  bool needs_reference = true;        ///< refuse frames without one
};

/// The sensor that a file describes: a JSON object of its own, or "sensor" of an experiment.
Sensor sensor_from_file(const std::filesystem::path& file);

/// Frames of a file, in V and in the order of the sensor's channels.
class OwnFrames {
 public:
  /// Throws InputError for whatever does not fit together, with what would be right.
  explicit OwnFrames(const OwnFramesOptions& options);

  /// With the background of the calibration where there is one.
  const Sensor& sensor() const { return sensor_; }
  const std::optional<Calibration>& calibration() const { return calibration_; }
  std::uint64_t frames() const { return source_->frames(); }
  const FrameSource& source() const { return *source_; }
  const ChannelMap& map() const { return map_; }
  /// The reference voltages [channels] V; of frames that each have their own, the mean.
  Eigen::RowVectorXd reference() const;

  Frames voltages(std::uint64_t first, std::uint64_t count) const;  ///< [count, channels] V
  Frames changes(std::uint64_t first, std::uint64_t count) const;   ///< from the reference, V

  /// Holds the reference against the model of the sensor, with up to a thousand frames spread over
  /// the file.
  ReferenceVerdict check() const;
  /// Reads all that follows as the verdict says.
  void mend(const ReferenceVerdict& verdict);

  /// What the output says of where it came from: `{"input": {"files", "checksum", "format",
  /// "dataset", "frames"}, "channels": {"order", "columns"}, "unit", "mended", "reference":
  /// "..."}`.
  nlohmann::json description() const;
  /// What was read: the frames' files, those of the sensor, order, background and calibration.
  std::vector<std::filesystem::path> inputs() const;

 private:
  void take_reference();
  Frames background_rows();

  OwnFramesOptions options_;
  std::unique_ptr<FrameSource> source_;
  std::optional<Calibration> calibration_;
  Sensor sensor_;
  ChannelMap map_;
  Frames references_;  ///< [1, channels] or [frames, channels] V
  std::string reference_text_;
  bool mended_ = false;
};

/// `options.background` as rows: "first-last". Nothing where it is no such thing.
std::optional<std::pair<std::uint64_t, std::uint64_t>> rows_of(const std::string& text);

}  // namespace ertbench
