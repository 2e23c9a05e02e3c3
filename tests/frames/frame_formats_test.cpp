// Files in the shapes that instruments and other programs write, with voltages of a disc's closed
// form, which shares nothing with the project: the same voltages, and the right place in the image.

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "core/errors.h"
#include "frames/own_frames.h"
#include "frames/text_lines.h"
#include "tests/bench/program.h"
#include "tests/forward/closed_form_disc.h"
#include "tests/frames/frames_testing.h"

namespace ertbench::testing {
namespace {

constexpr double closed_x = -50, closed_y = 0;  ///< of the inclusion, mm on a disc of 200 mm
constexpr double near_place = 8;                ///< mm

/// Channels of adjacent drive and measurement, those of `disc_16`.
std::vector<ChannelElectrodes> adjacent_channels() {
  std::vector<ChannelElectrodes> out;
  for (int d = 0; d < 16; ++d) {
    for (int m = 0; m < 16; ++m) {
      const int apart = (m - d + 17) % 16;
      if (apart > 2) out.push_back({{d, (d + 1) % 16}, {m, (m + 1) % 16}});
    }
  }
  return out;
}

/// Three frames without contact and one of an inclusion, for electrodes clockwise from the top.
RowMajorMatrix closed_form_frames(const std::vector<ChannelElectrodes>& channels,
                                  bool clockwise = true) {
  ClosedFormDisc disc(16, 90, clockwise);
  disc.current = 0.025;
  disc.conductivity = 0.06;
  RowMajorMatrix frames(4, std::ssize(channels));
  for (Eigen::Index c = 0; c < frames.cols(); ++c) {
    const ChannelElectrodes& channel = channels[static_cast<std::size_t>(c)];
    frames.col(c).setConstant(disc.voltage(channel));
    frames(3, c) = disc.voltage(channel, {{{closed_x / 100, closed_y / 100}, 0.1, 0.5}});
  }
  return frames;
}

using Cell = std::function<std::string(double)>;

std::string number(double value) {
  std::ostringstream out;
  out.precision(10);
  out << value;
  return out.str();
}

/// A line a frame, of cells that `cell` writes, each behind `before`.
std::string table_text(const RowMajorMatrix& rows, const std::string& separator,
                       const Cell& cell = number, const std::string& before = "",
                       const std::string& behind = "") {
  std::string out;
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    out += before;
    for (Eigen::Index c = 0; c < rows.cols(); ++c) {
      out += (c > 0 ? separator : "") + cell(rows(r, c));
    }
    out += behind + "\n";
  }
  return out;
}

std::string replaced(std::string text, char from, char to) {
  std::replace(text.begin(), text.end(), from, to);
  return text;
}

std::string utf16(const std::string& text, bool little, bool marked) {
  std::string out = !marked ? "" : little ? "\xff\xfe" : "\xfe\xff";
  for (const char c : text) {
    out += little ? c : '\0';
    out += little ? '\0' : c;
  }
  return out;
}

/// What is read of a file with these bytes, in V and in the order of disc_16.
Frames read_as_tank(const std::string& name, const std::string& bytes,
                    std::vector<std::string>* notes = nullptr, const std::string& dataset = "") {
  const TemporaryFolder folder("formats");
  write_text(folder / name, bytes);
  OwnFramesOptions options;
  options.input = folder / name;
  options.sensor = fs::path(ERTBENCH_SOURCE_DIR) / "sensors/disc_16.json";
  options.file.dataset = dataset;
  options.needs_reference = false;
  const OwnFrames frames(options);
  if (notes) *notes = frames.source().notes();
  return frames.voltages(0, frames.frames());
}

std::string refusal(const std::string& name, const std::string& bytes) {
  try {
    read_as_tank(name, bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FrameFormats, TablesInManyShapesAreTheSameVoltages) {
  const RowMajorMatrix frames = closed_form_frames(adjacent_channels());
  const std::string plain = table_text(frames, ",");
  const std::string tabs = table_text(frames, "\t");
  std::string counted =
      "frame;" + table_text(RowMajorMatrix::Zero(1, 208), ";", [](double) { return "ch"; });
  std::string stamped;
  std::string elapsed;
  for (Eigen::Index f = 0; f < 4; ++f) {
    const std::string row = table_text(frames.middleRows(f, 1), ";");
    counted += std::to_string(7 + f) + ";" + row;
    stamped += "2024-01-26 10:00:0" + std::to_string(f) + ";" + row;
    elapsed += "10:00:0" + std::to_string(f) + ";" + std::to_string(7 + f) + ";" +
               number(0.04 * static_cast<double>(f) + 0.001) + ";" + row;
  }
  const auto complex = [](const char* before, const char* behind) {
    return [=](double v) { return before + number(v) + behind; };
  };
  const std::pair<const char*, std::string> shapes[] = {
      {"plain", plain},
      {"decimal commas", replaced(table_text(frames, ";"), '.', ',')},
      {"decimal commas between tabs", replaced(tabs, '.', ',')},
      {"decimal commas between blanks", replaced(table_text(frames, "  "), '.', ',')},
      {"quoted decimal commas",
       table_text(frames, ",", [](double v) { return '"' + replaced(number(v), '.', ',') + '"'; })},
      {"UTF-16", utf16(plain, true, true)},
      {"UTF-16, the other way round", utf16(tabs, false, true)},
      {"UTF-16 without a mark", utf16(plain, true, false)},
      {"a comma at the end", table_text(frames, ",", number, "", ",")},
      {"lines of old Macs", replaced(plain, '\n', '\r')},
      {"words before", table_text(frames, ", ", number, "voltages : ")},
      {"words and a count before", table_text(frames, " ", number, "FRAME 208 ")},
      {"a list", table_text(frames, ", ", number, "data = [", "]")},
      {"JSON", table_text(frames, ", ", number, "{\"v\": [", "]}")},
      {"a clock before", table_text(frames, ",", number, "10:22:01.125 -> ")},
      {"counted frames", counted},
      {"stamped frames", stamped},
      {"a clock, a counter and elapsed seconds before", elapsed},
      {"titles of pandas",
       [&] {
         std::string text = "\"\"";
         for (int c = 0; c < 208; ++c) text += "," + std::to_string(c);
         for (Eigen::Index f = 0; f < 4; ++f) {
           text += "\n" + std::to_string(f) + "," + table_text(frames.middleRows(f, 1), ",");
         }
         return text;
       }()},
      {"instrument's head", "Device: X\nSamples: 20\nDate: 26.01.2024\n\n" + plain},
      {"complex", table_text(frames, ",", complex("", "-0.25i"))},
      {"complex with blanks", table_text(frames, "; ", complex("", " + 1.5e-3j"))},
      {"complex between blanks", table_text(frames, " ", complex("", " - 0.5j"))},
      {"pairs", table_text(frames, ",", complex("(", ",0.125)"))}};
  for (const auto& [what, text] : shapes) {
    SCOPED_TRACE(what);
    const Frames read = read_as_tank("frames.txt", text);
    ASSERT_EQ(read.rows(), 4);
    EXPECT_LT((read - frames).norm(), 1e-8 * frames.norm());
  }
  std::vector<std::string> notes;
  read_as_tank("frames.txt", counted, &notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("column 1 (\"frame\"): passed over"), std::string::npos) << notes[0];
}

TEST(FrameFormats, TablesThatCannotBeReadAreRefusedWithPlaceAndCause) {
  const RowMajorMatrix frames = closed_form_frames(adjacent_channels());
  const std::string plain = table_text(frames, ",");
  const auto with_cell = [&](const std::string& cell) {
    std::string text = plain;
    const std::size_t second = text.find('\n') + 1;
    return text.replace(second, text.find(',', second) - second, cell);
  };
  EXPECT_NE(refusal("f.csv", with_cell("OVL")).find("line 2, column 1: is not finite (\"OVL\")"),
            std::string::npos);
  EXPECT_NE(refusal("f.csv", with_cell("")).find("line 2, column 1: is empty"), std::string::npos);
  EXPECT_NE(refusal("f.csv", with_cell("1.2.3")).find("line 2, column 1: must be a number"),
            std::string::npos);
  EXPECT_NE(refusal("f.csv", replaced(plain, '.', ',')).find("cannot be told apart"),
            std::string::npos);
  EXPECT_NE(refusal("f.csv", "a : 1,2\nb : 3,4\n").find("line 2: begins with \"b :\""),
            std::string::npos);
  EXPECT_NE(refusal("f.csv", std::string("1,2\0\x03\x04\n", 7)).find("neither text nor"),
            std::string::npos);
  EXPECT_NE(refusal("f.bin", "---Draeger EIT-Software---\r\n").find("export it as text"),
            std::string::npos);
  EXPECT_NE(refusal("f.eit", "---Draeger EIT-Software---\r\n").find("export it as text"),
            std::string::npos);
}

/// Titled columns as they come: every third drive reversed, in another order.
std::string titled_text(const std::string& separator, const std::string& start,
                        const std::string& unit, int count_from) {
  std::vector<ChannelElectrodes> channels = adjacent_channels();
  std::reverse(channels.begin(), channels.end());
  for (std::size_t c = 0; c < channels.size(); c += 3) {
    std::swap(channels[c].drive.first, channels[c].drive.second);
  }
  const RowMajorMatrix frames = closed_form_frames(channels);
  std::string text = "Timestamp";
  for (const auto& [drive, measurement] : channels) {
    std::string name = start;
    for (const int e : {drive.first, drive.second, measurement.first, measurement.second}) {
      name += (e + count_from < 10 ? "E0" : "E") + std::to_string(e + count_from) + "_";
    }
    text += separator + name + "Magnitude" + unit + separator + name + "Phase";
  }
  for (Eigen::Index f = 0; f < frames.rows(); ++f) {
    text += "\n2024-01-26 10:00:0" + std::to_string(f);
    for (const double v : frames.row(f)) {
      text += separator + number(1e3 * std::abs(v)) + separator + (v < 0 ? "-178.5" : "1.5");
    }
  }
  return text + "\n";
}

/// Runs `reconstruct` and holds the strongest change of the last frame against its place.
void expect_place(const TemporaryFolder& folder, const std::string& options, std::uint64_t frame) {
  write_text(folder / "gn.json", R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.1})");
  const Outcome images =
      run_program(folder.path(), "reconstruct --solver gn.json --output images.h5 " + options);
  ASSERT_EQ(images.exit_code, 0) << images.output;
  EXPECT_LT((strongest(folder / "images.h5", frame) - Eigen::Vector2d(closed_x, closed_y)).norm(),
            near_place);
}

TEST(FrameFormats, TitlesGiveTheChannels) {
  const Frames expected = closed_form_frames(adjacent_channels());
  for (const auto& [separator, start, unit, from] :
       {std::tuple(",", "", " [mV]", 1), std::tuple(";", "\"V ", " (mV)\"", 0),
        std::tuple("\t", "Z", "_mV", 1)}) {
    std::string text = titled_text(separator, start, unit, from);
    if (*start == '"') {  // phases are quoted, too
      for (std::size_t at = 0; (at = text.find("Phase", at)) != std::string::npos; at += 6) {
        text.insert(at + 5, "\"");
      }
    }
    const Frames read = read_as_tank("belt.csv", text);
    EXPECT_LT((read - std::cos(1.5 * std::numbers::pi / 180) * expected).norm(),
              1e-6 * expected.norm());
  }
  const TemporaryFolder folder("titled");
  write_text(folder / "belt.csv", titled_text(",", "", " [mV]", 1));
  const std::string sensor = std::string(ERTBENCH_SOURCE_DIR) + "/sensors/disc_16.json";
  expect_place(folder, "--sensor " + sensor + " --input belt.csv --background 0-2", 3);
  // Amplitudes behind words.
  write_text(folder / "record.txt",
             table_text(
                 expected, ",", [](double v) { return number(std::abs(v)); }, "magnitudes : "));
  expect_place(folder, "--fix --sensor " + sensor + " --input record.txt --background 0-2", 3);

  const ColumnTitle title = column_title("V(3,4;1,2) imag [uV]");
  EXPECT_EQ(title.electrodes, (std::array{3, 4, 1, 2}));
  EXPECT_EQ(title.kind, ColumnTitle::Kind::imaginary);
  EXPECT_EQ(title.unit, "uV");
  EXPECT_NE(refusal("t.csv", "1_2_3_4,1_2_3_4\n1,2\n").find("name the channel 1 2 3 4 twice"),
            std::string::npos);
  EXPECT_NE(refusal("t.csv", "1_2_3_4 mag,1_2_3_4 phase\n1,1.5\n").find("degrees or radians"),
            std::string::npos);
}

/// The last frame, or the first, in BERT's format: counterclockwise from the top, current into a
/// where `into_a`.
std::string unified_text(Eigen::Index frame, bool into_a, const std::string& columns) {
  const std::vector<ChannelElectrodes> channels = adjacent_channels();
  const RowMajorMatrix frames = closed_form_frames(channels, false) / 0.025;
  std::string text = "16# Number of sensors\n#x y\n";
  for (int e = 0; e < 16; ++e) {
    const double angle = std::numbers::pi / 8 * e;
    text += number(-0.1 * std::sin(angle)) + " " + number(0.3 + 0.1 * std::cos(angle)) + "\n";
  }
  text += "208# Number of data\n#a b m n " + columns + "\n";
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto& [drive, measurement] = channels[c];
    for (const int e : {drive.first, drive.second, measurement.first, measurement.second}) {
      text += std::to_string(e + 1) + "\t";
    }
    const double r = frames(frame, static_cast<Eigen::Index>(c)) * (into_a ? -1 : 1);
    text += columns == "r valid" ? number(r) + "\t1\n" : number(r * 0.002) + "\t0.002\n";
  }
  return text + "0\n";
}

TEST(FrameFormats, TheUnifiedFormatBringsItsSensor) {
  for (const bool into_a : {true, false}) {
    const TemporaryFolder folder("unified");
    write_text(folder / "empty.dat", unified_text(0, into_a, "u/V i/A"));
    write_text(folder / "object.dat", unified_text(3, into_a, "r valid"));
    expect_place(folder, "--input object.dat --background empty.dat", 0);
  }
  const std::string good = unified_text(0, true, "r valid");
  {
    // What is not valid in either file is left out, whatever stands there.
    const TemporaryFolder folder("unified");
    std::string object = unified_text(3, true, "r valid");
    const std::size_t line = object.find("\n1\t2\t3\t4\t") + 1;
    object.replace(line, object.find('\n', line) - line, "1\t2\t3\t4\t1e9\t0");
    write_text(folder / "empty.dat", good);
    write_text(folder / "object.dat", object);
    expect_place(folder, "--input object.dat --background empty.dat", 0);
    EXPECT_TRUE(std::isnan(parse_unified(object, "f").resistances.front()));
  }
  const UnifiedFile file = parse_unified(good, "f");
  EXPECT_NEAR(file.sensor.sheet->unit_mm(), 100, 1e-6);
  EXPECT_EQ(file.sensor.channels(), 208);
  const auto damaged = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    try {
      parse_unified(text, "f");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(damaged("#a b m n r valid", "#a b m n err ip").find("f: line 20: has no resistances"),
            std::string::npos);
  EXPECT_NE(damaged("1\t2\t3\t4", "0\t2\t3\t4").find("f: line 21: electrodes are"),
            std::string::npos);
  EXPECT_NE(damaged("1\t2\t3\t4", "1\t2\t4\t5").find("came before"), std::string::npos);
  EXPECT_NE(damaged("208#", "209#").find("numbers"), std::string::npos);
  EXPECT_NE(damaged("\n-0 0.4\n", "\n-0 0.3\n").find("f: line"), std::string::npos);
}

std::string floats(const RowMajorMatrix& rows) {
  std::string bytes;
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    for (const double v : rows.row(r)) {
      const auto one = static_cast<float>(v);
      bytes.append(reinterpret_cast<const char*>(&one), sizeof one);
    }
  }
  return bytes;
}

TEST(FrameFormats, GetRecordingsAreRotatingFramesOrMaps) {
  // EIDORS untwists the third drive's 13 values so: the last one is of pair 0, the others of 4 ...
  const std::vector<ChannelElectrodes> channels = adjacent_channels();
  const RowMajorMatrix expected = closed_form_frames(channels);
  RowMajorMatrix rotating = RowMajorMatrix::Constant(4, 256, 7);
  RowMajorMatrix maps = RowMajorMatrix::Zero(4, 256);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const int d = channels[c].drive.first;
    const int m = channels[c].measurement.first;
    rotating.col(13 * d + (m - d - 2 + 16) % 16) = expected.col(static_cast<Eigen::Index>(c));
    maps.col(16 * d + m) = expected.col(static_cast<Eigen::Index>(c));
  }
  for (const RowMajorMatrix& rows : {rotating, maps}) {
    EXPECT_LT((read_as_tank("a.get", floats(rows)) - expected).norm(), 1e-6 * expected.norm());
  }
  EXPECT_NE(refusal("a.get", floats(rotating).substr(1)).find("is cut off"), std::string::npos);
  rotating(2, 5) = std::nan("");
  EXPECT_NE(refusal("a.get", floats(rotating)).find("frame 2, value 5"), std::string::npos);
}

/// A matrix of a level-5 file, after MathWorks' description of the format.
std::string mat_element(const std::string& name, const RowMajorMatrix& rows) {
  const auto word = [](std::uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto padded = [](std::string text) {
    text.resize((text.size() + 7) / 8 * 8);
    return text;
  };
  const Eigen::MatrixXd by_columns = rows;
  const auto size = static_cast<std::uint32_t>(by_columns.size() * 8);
  const std::string content = word(6) + word(8) + word(6) + word(0) + word(5) + word(8) +
                              word(static_cast<std::uint32_t>(rows.rows())) +
                              word(static_cast<std::uint32_t>(rows.cols())) + word(1) +
                              word(static_cast<std::uint32_t>(name.size())) + padded(name) +
                              word(9) + word(size) +
                              std::string(reinterpret_cast<const char*>(by_columns.data()), size);
  return word(14) + word(static_cast<std::uint32_t>(content.size())) + content;
}

TEST(FrameFormats, MatlabsOlderFilesAreRead) {
  std::string head = "MATLAB 5.0 MAT-file, written by hand";
  head.resize(124, ' ');
  head += std::string("\x00\x01IM", 4);
  const RowMajorMatrix frames = closed_form_frames(adjacent_channels());
  const RowMajorMatrix other = RowMajorMatrix::Constant(1, 3, 5);
  EXPECT_EQ(
      read_as_tank("a.mat", head + mat_element("other", other) + mat_element("voltages", frames)),
      frames);
  EXPECT_EQ(read_as_tank("a.mat", head + mat_element("mine", frames)), frames);
  EXPECT_EQ(read_as_tank("a.mat", head + mat_element("b", other) + mat_element("c", frames),
                         nullptr, "c"),
            frames);
  // EIDORS has frames in columns: vh without, vi with contact.
  EXPECT_EQ(read_as_tank("a.mat", head + mat_element("vh", frames.topRows(1).transpose()) +
                                      mat_element("vi", frames.transpose())),
            frames);
  EXPECT_NE(refusal("a.mat", head + mat_element("b", other) + mat_element("c", frames))
                .find("--dataset, one of b, c"),
            std::string::npos);
  const std::string whole = head + mat_element("voltages", frames);
  for (const std::size_t length :
       {std::size_t{36}, std::size_t{130}, std::size_t{200}, whole.size() / 2}) {
    EXPECT_NE(refusal("a.mat", whole.substr(0, length)).find("a.mat: is cut off"),
              std::string::npos)
        << length;
  }
}

}  // namespace
}  // namespace ertbench::testing
