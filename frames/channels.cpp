#include "frames/channels.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "core/errors.h"
#include "core/lists.h"
#include "core/text.h"
#include "forward/sheet/sensor_json.h"

namespace ertbench {

Frames ChannelMap::apply(const RowMajorMatrix& table) const {
  Frames frames(table.rows(), static_cast<Eigen::Index>(entries.size()));
  for (Eigen::Index row = 0; row < table.rows(); ++row) {
    for (std::size_t c = 0; c < entries.size(); ++c) {
      const Entry& entry = entries[c];
      double value = table(row, entry.plus);
      if (entry.minus >= 0) value -= table(row, entry.minus);
      frames(row, static_cast<Eigen::Index>(c)) = entry.factor * value;
    }
  }
  return frames;
}

ChannelMap ChannelMap::mended(const std::vector<int>& from, const Eigen::VectorXd& factor) const {
  ChannelMap out{order, columns, {}};
  for (std::size_t c = 0; c < from.size(); ++c) {
    Entry entry = entries[static_cast<std::size_t>(from[c])];
    entry.factor *= factor[static_cast<Eigen::Index>(c)];
    out.entries.push_back(entry);
  }
  return out;
}

ChannelMap ChannelMap::of_channels(const std::vector<int>& kept) const {
  return mended(kept, Eigen::VectorXd::Ones(std::ssize(kept)));
}

RowMajorMatrix ChannelMap::table() const {
  RowMajorMatrix out(static_cast<Eigen::Index>(entries.size()), 3);
  for (std::size_t c = 0; c < entries.size(); ++c) {
    out.row(static_cast<Eigen::Index>(c)) << static_cast<double>(entries[c].plus),
        static_cast<double>(entries[c].minus), entries[c].factor;
  }
  return out;
}

namespace {

constexpr NamedOrder orders[] = {
    {"drive-major", "drive by drive, measurements ascending (the sensor's own)"},
    {"measure-major", "measurement by measurement, drives ascending"},
    {"rotating", "drive by drive, measurements from the one behind the drive on"},
    {"rotating-back", "drive by drive, measurements going back from the drive"},
    {"full", "all measurements of all drives, drive by drive"},
    {"full-measure-major", "all drives of all measurements, measurement by measurement"},
    {"potentials", "the potential of every electrode, drive by drive"}};

/// Stands for the frames of a stream, which has as many columns as an order needs.
class StreamColumns final : public FrameSource {
 public:
  explicit StreamColumns(Eigen::Index columns) : columns_(columns) {}
  std::string format() const override { return "CSV"; }
  std::uint64_t frames() const override { return 1; }
  Eigen::Index columns() const override { return columns_; }
  RowMajorMatrix read(std::uint64_t, std::uint64_t) const override { return {}; }
  std::vector<std::filesystem::path> files() const override { return {"--input"}; }

 private:
  Eigen::Index columns_;
};

std::string source_name(const FrameSource& source) { return source.files().front().string(); }

[[noreturn]] void refuse_columns(const FrameSource& source, Eigen::Index expected,
                                 const std::string& order) {
  const std::string place =
      source_name(source) + ": " + (source.dataset().empty() ? "" : source.dataset() + ": ");
  const std::string columns = std::to_string(source.columns());
  if (source.frames() == static_cast<std::uint64_t>(expected)) {
    throw InputError(place + "must have shape [N, " + std::to_string(expected) + "], has [" +
                     std::to_string(source.frames()) + ", " + columns +
                     "]; --transposed reads frames that are columns");
  }
  throw InputError(place + "must have shape [N, " + std::to_string(expected) + "], has [" +
                   std::to_string(source.frames()) + ", " + columns + "]; the sensor has so many " +
                   (order.empty() ? "channels" : "columns in the order \"" + order + "\"") +
                   ": name another --sensor or --channels");
}

double factor_of(const std::string& unit) {
  if (unit.empty() || unit == "V") return 1;
  if (unit == "mV") return 1e-3;
  if (unit == "uV" || unit == "µV") return 1e-6;
  throw InputError("--unit: must be V, mV or uV, got \"" + printable(unit) + "\"");
}

/// The map whose channel c is column `places[c]`.
ChannelMap map_of_places(const std::string& order, Eigen::Index columns,
                         const std::vector<int>& places) {
  ChannelMap map{order, columns, {}};
  for (const int place : places) map.entries.push_back({place, -1, 1});
  return map;
}

/// The map for columns [drives][electrodes].
ChannelMap map_of_potentials(const Sensor& sensor) {
  const auto measured = measurement_pairs(sensor);
  const Eigen::Index electrodes = sensor.electrode_count;
  ChannelMap map{"potentials", sensor.drives() * electrodes, {}};
  for (const Channel& channel : channels_of(sensor)) {
    const auto& [first, second] = measured[static_cast<std::size_t>(channel.measurement)];
    map.entries.push_back(
        {channel.drive * electrodes + first, channel.drive * electrodes + second, 1});
  }
  return map;
}

/// The map by the injections that the file lists, in either direction; unused ones are ignored.
ChannelMap map_of_injections(const Sensor& sensor, const FrameSource& source) {
  const std::vector<Injection> injections = source.injections();
  const std::vector<int> electrodes = source.electrodes();
  const auto column_of = [&](int electrode) {
    const auto found = std::ranges::find(electrodes, electrode);
    if (found == electrodes.end()) {
      throw InputError(source_name(source) + ": measures no electrode " +
                       std::to_string(electrode + 1) + ", which the sensor has; name another " +
                       "--sensor");
    }
    return static_cast<Eigen::Index>(found - electrodes.begin());
  };
  ChannelMap map{"injections of the file", source.columns(), {}};
  for (const auto& [drive, measurement] : electrodes_of_channels(sensor)) {
    const auto& [sink, entry] = drive;
    Eigen::Index run = -1;
    double sign = 1;
    for (std::size_t i = 0; i < injections.size(); ++i) {
      const bool same = injections[i] == Injection{entry, sink};
      if (!same && injections[i] != Injection{sink, entry}) continue;
      run = static_cast<Eigen::Index>(i);
      sign = same ? 1 : -1;
    }
    if (run < 0) {
      throw InputError(source_name(source) + ": has no injection between the electrodes " +
                       std::to_string(sink + 1) + " and " + std::to_string(entry + 1) +
                       ", which the sensor drives; name the --sensor of the recording");
    }
    const auto& [first, second] = measurement;
    const Eigen::Index begin = run * static_cast<Eigen::Index>(electrodes.size());
    map.entries.push_back({begin + column_of(first), begin + column_of(second), sign});
  }
  return map;
}

using ColumnsByElectrodes = std::map<ChannelElectrodes, Eigen::Index>;

ColumnsByElectrodes columns_by_electrodes(const std::vector<ChannelElectrodes>& named) {
  ColumnsByElectrodes out;
  Eigen::Index column = 0;
  for (const ChannelElectrodes& one : named) out.try_emplace(one, column++);
  return out;
}

/// Column and sign of a channel, whose pairs may be reversed there; nothing if it has no column.
std::optional<std::pair<Eigen::Index, double>> find_column(const ColumnsByElectrodes& columns,
                                                           const ChannelElectrodes& channel) {
  const auto turned = [](const ElectrodePair& pair, bool turn) {
    return turn ? ElectrodePair{pair.second, pair.first} : pair;
  };
  for (const bool drive : {false, true}) {
    for (const bool measurement : {false, true}) {
      const auto found =
          columns.find({turned(channel.drive, drive), turned(channel.measurement, measurement)});
      if (found != columns.end())
        return std::pair(found->second, drive == measurement ? 1.0 : -1.0);
    }
  }
  return std::nullopt;
}

/// The electrodes of the columns as the source or the file `order` names them; may be empty.
std::vector<ChannelElectrodes> named_columns(const Sensor& sensor, const FrameSource& source,
                                             const std::string& order) {
  if (order.empty()) return source.channels();
  std::error_code error;
  const bool is_list = std::filesystem::is_regular_file(order, error) &&
                       numbers_of_text(text_of_file(order), order).cols() == 4;
  return is_list ? read_channels(order, sensor.electrode_count) : std::vector<ChannelElectrodes>();
}

ChannelMap map_of_electrodes(const Sensor& sensor, const FrameSource& source,
                             const std::vector<ChannelElectrodes>& named,
                             const std::string& order) {
  if (std::ssize(named) != source.columns()) {
    throw InputError(order + ": names " + std::to_string(named.size()) + " channels, " +
                     source_name(source) + " has " + std::to_string(source.columns()) + " columns");
  }
  const ColumnsByElectrodes columns = columns_by_electrodes(named);
  ChannelMap map{order, source.columns(), {}};
  for (const ChannelElectrodes& channel : electrodes_of_channels(sensor)) {
    const auto found = find_column(columns, channel);
    if (!found) {
      const auto& [drive, measurement] = channel;
      throw InputError(order + ": no column has drive " + std::to_string(drive.first) + ", " +
                       std::to_string(drive.second) + " and measurement " +
                       std::to_string(measurement.first) + ", " +
                       std::to_string(measurement.second) +
                       " (electrodes from 0), a channel of the sensor");
    }
    map.entries.push_back({found->first, -1, found->second});
  }
  return map;
}

/// `lines` [columns, 2 or 3]: drive, measurement, sign.
ChannelMap map_of_lines(const Sensor& sensor, const FrameSource& source,
                        const RowMajorMatrix& lines, const std::string& order) {
  const auto fail = [&](Eigen::Index line, const std::string& what) {
    throw InputError(order + ": column " + std::to_string(line) + ": " + what);
  };
  if (lines.cols() != 2 && lines.cols() != 3) {
    throw InputError(order + ": must have a line \"drive measurement\" for each column, with a " +
                     "sign behind them or without");
  }
  if (lines.rows() != source.columns()) {
    throw InputError(order + ": has lines for " + std::to_string(lines.rows()) + " columns, " +
                     source_name(source) + " has " + std::to_string(source.columns()));
  }
  const std::vector<Channel> channels = channels_of(sensor);
  ChannelMap map{order, source.columns(), {}};
  map.entries.resize(channels.size());
  std::vector<Eigen::Index> stands(channels.size(), -1);
  for (Eigen::Index line = 0; line < lines.rows(); ++line) {
    const double sign = lines.cols() == 3 ? lines(line, 2) : 1;
    if (std::abs(sign) != 1) fail(line, "the sign must be 1 or -1");
    const auto found = std::ranges::find_if(channels, [&](const Channel& channel) {
      return channel.drive == lines(line, 0) && channel.measurement == lines(line, 1);
    });
    if (found == channels.end()) continue;
    const auto c = static_cast<std::size_t>(found - channels.begin());
    if (stands[c] >= 0) {
      fail(line, "is the same channel as column " + std::to_string(stands[c]));
    }
    stands[c] = line;
    map.entries[c] = {line, -1, sign};
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (stands[c] < 0) {
      throw InputError(order + ": no column has drive " + std::to_string(channels[c].drive) +
                       " and measurement " + std::to_string(channels[c].measurement) +
                       ", a channel of the sensor; both are counted from 0");
    }
  }
  return map;
}

ChannelMap map_in_volts(const Sensor& sensor, const FrameSource& source, const std::string& order) {
  const Eigen::Index drives = sensor.drives();
  const Eigen::Index measurements = sensor.measurements();
  const Eigen::Index channels = sensor.channels();
  if (order.empty() && !source.injections().empty()) return map_of_injections(sensor, source);
  if (const auto named = named_columns(sensor, source, order); !named.empty()) {
    return map_of_electrodes(sensor, source, named,
                             order.empty() ? "the columns' electrodes" : order);
  }
  std::string name = order;
  if (order.empty()) {
    const bool is_full = source.columns() == drives * measurements;
    name = is_full && source.columns() != channels ? "full" : "drive-major";
  }
  const auto require = [&](Eigen::Index columns) {
    if (source.columns() != columns) refuse_columns(source, columns, order);
  };
  if (name == "full" || name == "full-measure-major") {
    require(drives * measurements);
    std::vector<int> places;
    for (const Channel& channel : channels_of(sensor)) {
      const Eigen::Index place = name == "full" ? channel.drive * measurements + channel.measurement
                                                : channel.measurement * drives + channel.drive;
      places.push_back(static_cast<int>(place));
    }
    return map_of_places(name, drives * measurements, places);
  }
  if (name == "potentials") {
    ChannelMap map = map_of_potentials(sensor);
    require(map.columns);
    return map;
  }
  if (name == "drive-major" || name == "measure-major" || name == "rotating" ||
      name == "rotating-back") {
    require(channels);
    return map_of_places(name, channels, places_in_order(sensor, name));
  }
  if (name.starts_with('/') && source.format() != "CSV" && source.format() != "eit") {
    return map_of_lines(sensor, source, source.table(name), source_name(source) + ": " + name);
  }
  std::error_code error;
  if (!std::filesystem::exists(name, error)) {
    throw InputError("--channels: must be one of " + joined(orders, ", ", &NamedOrder::name) +
                     ", or a file with a line \"drive measurement\" for each column; \"" +
                     printable(name) + "\" does not exist");
  }
  return map_of_lines(sensor, source, numbers_of_text(text_of_file(name), name), name);
}

/// Refuses frames that are arrays of two dimensions of which the first is not the order's.
void require_shape(const Sensor& sensor, const FrameSource& source, const ChannelMap& map) {
  const std::vector<std::uint64_t> shape = source.frame_shape();
  const auto is_order = [&](const NamedOrder& order) { return order.name == map.order; };
  if (shape.empty() || std::none_of(std::begin(orders), std::end(orders), is_order)) return;
  const bool by_measurement = map.order.find("measure-major") != std::string::npos;
  const auto first =
      static_cast<std::uint64_t>(by_measurement ? sensor.measurements() : sensor.drives());
  if (shape[0] == first) return;
  const auto text = [](std::uint64_t a, std::uint64_t b) {
    return "[N, " + std::to_string(a) + ", " + std::to_string(b) + "]";
  };
  throw InputError(source_name(source) + ": has shape " + text(shape[0], shape[1]) +
                   ", frames in the order " + map.order + " have " +
                   text(first, static_cast<std::uint64_t>(map.columns) / first) +
                   (shape[1] == first
                        ? ": drives and measurements are exchanged; turn the last two dimensions "
                          "(numpy: voltages.transpose(0, 2, 1))"
                        : ": these are no drives and measurements of this sensor; save them so, or "
                          "as [N, " +
                              std::to_string(map.columns) + "]"));
}

}  // namespace

std::span<const NamedOrder> named_orders() { return orders; }

Sensor sensor_of_columns(const Sensor& sensor, const FrameSource& source,
                         const std::string& order) {
  const std::vector<ChannelElectrodes> named = named_columns(sensor, source, order);
  if (named.empty() || !sensor.listed_channels.empty()) return sensor;
  const ColumnsByElectrodes columns = columns_by_electrodes(named);
  const std::vector<ChannelElectrodes> own = electrodes_of_channels(sensor);
  const bool covers = std::ranges::all_of(own, [&](const ChannelElectrodes& channel) {
    return find_column(columns, channel).has_value();
  });
  return covers ? sensor : with_channels(sensor, named);
}

std::vector<int> places_in_order(const Sensor& sensor, const std::string& name) {
  const std::vector<Channel> channels = channels_of(sensor);
  const int measurements = sensor.measurements();
  std::vector<int> file(channels.size());  // the channels in the order of the file
  for (std::size_t c = 0; c < file.size(); ++c) file[c] = static_cast<int>(c);
  const auto channel = [&](int c) { return channels[static_cast<std::size_t>(c)]; };
  if (name == "measure-major") {
    std::ranges::sort(file, [&](int a, int b) {
      return std::pair(channel(a).measurement, channel(a).drive) <
             std::pair(channel(b).measurement, channel(b).drive);
    });
  } else if (name == "rotating" || name == "rotating-back") {
    const int way = name == "rotating" ? 1 : -1;
    const auto behind = [&](int c) {
      const int apart = channel(c).measurement - channel(c).drive % measurements;
      return (way * apart + measurements) % measurements;
    };
    std::ranges::sort(file, [&](int a, int b) {
      return std::pair(channel(a).drive, behind(a)) < std::pair(channel(b).drive, behind(b));
    });
  } else if (name != "drive-major") {
    throw std::invalid_argument("an order of other columns than the channels");
  }
  std::vector<int> places(file.size());
  for (std::size_t p = 0; p < file.size(); ++p) {
    places[static_cast<std::size_t>(file[p])] = static_cast<int>(p);
  }
  return places;
}

ChannelMap channel_map(const Sensor& sensor, const FrameSource& source, const std::string& order,
                       const std::string& unit) {
  const std::string said = source.unit();
  if (!unit.empty() && !said.empty() && factor_of(unit) != factor_of(said)) {
    throw InputError("--unit " + printable(unit) + ": " + source_name(source) + " says " + said +
                     "; leave --unit out");
  }
  const double factor = factor_of(unit.empty() ? said : unit);
  ChannelMap map = map_in_volts(sensor, source, order);
  require_shape(sensor, source, map);
  for (ChannelMap::Entry& entry : map.entries) entry.factor *= factor;
  return map;
}

ChannelMap channel_map(const Sensor& sensor, const std::string& order, const std::string& unit) {
  Eigen::Index columns = sensor.channels();
  std::error_code error;
  if (order.starts_with("full")) {
    columns = Eigen::Index{sensor.drives()} * sensor.measurements();
  } else if (order == "potentials") {
    columns = Eigen::Index{sensor.drives()} * sensor.electrode_count;
  } else if (std::filesystem::is_regular_file(order, error)) {
    columns = numbers_of_text(text_of_file(order), order).rows();
  }
  return channel_map(sensor, StreamColumns(columns), order.empty() ? "drive-major" : order, unit);
}

}  // namespace ertbench
