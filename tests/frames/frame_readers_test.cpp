// The readers of frames: the same frames through every format and order, and what is refused.

#include <gtest/gtest.h>

#include <fstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "frames/channels.h"
#include "frames/frame_source.h"
#include "frames/own_frames.h"
#include "tests/forward/disc_sheet.h"
#include "tests/frames/frames_testing.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

std::string why_refused(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void write_file(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string text_of(const RowMajorMatrix& rows, const char* separator) {
  std::ostringstream out;
  out.precision(17);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    for (Eigen::Index c = 0; c < rows.cols(); ++c) out << (c ? separator : "") << rows(r, c);
    out << '\n';
  }
  return out.str();
}

/// A small map that tells every place: drive + measurement/100, frames apart by ten.
RowMajorMatrix whole_maps(const Sensor& sensor, bool by_measurement) {
  const int count = sensor.electrode_count;
  RowMajorMatrix maps(3, count * count);
  for (int f = 0; f < 3; ++f) {
    for (int d = 0; d < count; ++d) {
      for (int m = 0; m < count; ++m) {
        maps(f, by_measurement ? m * count + d : d * count + m) = 100 * (f + 1) + d + m / 100.0;
      }
    }
  }
  return maps;
}

Frames channels_of_maps(const Sensor& sensor) {
  const std::vector<Channel> channels = channels_of(sensor);
  Frames out(3, sensor.channels());
  for (int f = 0; f < 3; ++f) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      out(f, static_cast<Eigen::Index>(c)) =
          100 * (f + 1) + channels[c].drive + channels[c].measurement / 100.0;
    }
  }
  return out;
}

OwnFramesOptions options_for(const fs::path& file, const std::string& channels = "") {
  OwnFramesOptions options;
  options.input = file;
  options.channels = channels;
  options.needs_reference = false;
  return options;
}

TEST(FrameReaders, OrdersComeToTheSameChannels) {
  const TemporaryFolder folder("orders");
  const Sensor sensor;
  const Frames expected = channels_of_maps(sensor);
  write_file(folder / "full.csv", text_of(whole_maps(sensor, false), ","));
  write_file(folder / "turned.csv", text_of(whole_maps(sensor, true), "\t"));
  write_file(folder / "columns.txt", text_of(whole_maps(sensor, false).transpose(), " "));
  EXPECT_EQ(OwnFrames(options_for(folder / "full.csv")).voltages(0, 3), expected);
  EXPECT_EQ(OwnFrames(options_for(folder / "turned.csv", "full-measure-major")).voltages(0, 3),
            expected);
  OwnFramesOptions columns = options_for(folder / "columns.txt", "full");
  columns.file.transposed = true;
  columns.unit = "mV";
  EXPECT_LT((1e3 * OwnFrames(columns).voltages(0, 3) - expected).norm(), 1e-9);

  // A list of the columns: whole maps, but the other way round, and every second one negative.
  std::string list = "# drive measurement sign\n";
  RowMajorMatrix maps = whole_maps(sensor, false).rowwise().reverse();
  for (Eigen::Index c = 0; c < maps.cols(); ++c) {
    const Eigen::Index place = maps.cols() - 1 - c;
    const int sign = c % 2 ? -1 : 1;
    maps.col(c) *= sign;
    list += std::to_string(place / 16) + " " + std::to_string(place % 16) + " " +
            std::to_string(sign) + "\n";
  }
  write_file(folder / "listed.csv", text_of(maps, "; "));
  write_file(folder / "order.txt", list);
  EXPECT_EQ(OwnFrames(options_for(folder / "listed.csv", folder / "order.txt")).voltages(0, 3),
            expected);

  // Potentials of the electrodes whose differences are known.
  RowMajorMatrix potentials(1, 256);
  for (int d = 0; d < 16; ++d) {
    for (int e = 0; e < 16; ++e) potentials(0, d * 16 + e) = d * e * e;
  }
  write_file(folder / "potentials.csv", text_of(potentials, ","));
  const Frames differences =
      OwnFrames(options_for(folder / "potentials.csv", "potentials")).voltages(0, 1);
  const std::vector<Channel> channels = channels_of(sensor);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const int e = channels[c].measurement;
    const int next = (e + 1) % 16;
    EXPECT_EQ(differences(0, static_cast<Eigen::Index>(c)),
              channels[c].drive * (e * e - next * next));
  }
}

TEST(FrameReaders, RotatingOrderIsThatOfEidors) {
  // EIDORS's mk_stim_patterns with "rotate_meas": of the first drive pairs 2, 3, ..., 14, of drive
  // 3 pairs 5, ..., 15, 0, 1.
  const Sensor sensor;
  const std::vector<int> places = places_in_order(sensor, "rotating");
  const std::vector<Channel> channels = channels_of(sensor);
  std::vector<int> measured(places.size());
  for (std::size_t c = 0; c < places.size(); ++c) {
    measured[static_cast<std::size_t>(places[c])] = channels[c].measurement;
  }
  const std::vector<int> of_third(measured.begin() + 3 * 13, measured.begin() + 4 * 13);
  EXPECT_EQ(of_third, (std::vector<int>{5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1}));
}

TEST(FrameReaders, MatlabArraysAreTurnedRound) {
  const TemporaryFolder folder("matlab");
  const Sensor sensor;
  const Frames expected = channels_of_maps(sensor);
  {
    // As MATLAB stores [3, 208] and [3, 16, 16]: the first index is the fastest.
    Hdf5File file = Hdf5File::create(folder / "plain.h5");
    file.write_matrix("/voltages", expected.transpose());
    file.write_text("/voltages", "MATLAB_class", "double");
    file.write_matrix("/reference_voltages", expected.row(0));
    file.create_dataset("/session/maps", {16, 16, 3});
    RowMajorMatrix stored(16, 16 * 3);
    const RowMajorMatrix maps = whole_maps(sensor, false);
    for (int f = 0; f < 3; ++f) {
      for (int d = 0; d < 16; ++d) {
        for (int m = 0; m < 16; ++m) stored(m, d * 3 + f) = maps(f, d * 16 + m);
      }
    }
    file.write_rows("/session/maps", 0, stored);
    file.create_dataset("/cells", {1, 2});
    file.write_text("/cells", "MATLAB_class", "cell");
    file.close();
  }
  std::ifstream in(folder / "plain.h5", std::ios::binary);
  std::string header = "MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .";
  header.resize(512, ' ');
  write_file(folder / "frames.mat", header + std::string(std::istreambuf_iterator<char>(in), {}));

  const OwnFrames frames(options_for(folder / "frames.mat"));
  EXPECT_EQ(frames.source().format(), "MATLAB v7.3");
  EXPECT_EQ(frames.voltages(0, 3), expected);
  EXPECT_EQ(frames.changes(0, 1), Frames::Zero(1, 208));
  OwnFramesOptions maps = options_for(folder / "frames.mat");
  maps.file.dataset = "session/maps";
  EXPECT_EQ(OwnFrames(maps).voltages(0, 3), expected);
  maps.file.dataset = "cells";
  EXPECT_NE(why_refused([&] { OwnFrames refused(maps); }).find("is a cell array; save a matrix"),
            std::string::npos);
}

TEST(FrameReaders, BackgroundIsAMeanOfRowsOrOfAFile) {
  const TemporaryFolder folder("background");
  const Sensor sensor;
  const Frames frames = channels_of_maps(sensor);
  write_file(folder / "frames.csv", text_of(frames, ","));
  OwnFramesOptions options = options_for(folder / "frames.csv");
  options.needs_reference = true;
  EXPECT_NE(why_refused([&] { OwnFrames none(options); }).find("--background"), std::string::npos);
  for (const std::string& background : {std::string("0-2"), (folder / "frames.csv").string()}) {
    options.background = background;
    EXPECT_LT((OwnFrames(options).reference() - frames.row(1)).norm(), 1e-9);
  }
  options.background = "1-3";
  EXPECT_NE(why_refused([&] { OwnFrames beyond(options); }).find("not among the 3"),
            std::string::npos);

  // A reference for each frame.
  Hdf5File file = Hdf5File::create(folder / "each.h5");
  file.write_matrix("/voltages", frames);
  file.write_matrix("/reference_voltages", 0.5 * frames);
  file.close();
  const OwnFrames each(options_for(folder / "each.h5"));
  EXPECT_EQ(each.changes(1, 2), 0.5 * frames.bottomRows(2));
}

TEST(FrameReaders, TextThatIsNoTableIsRefusedWithItsPlace) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "holds no numbers"},
      {"# nothing\n\n", "holds no numbers"},
      {"a,b\n1,2\n3,x\n", "t: line 3, column 2: must be a number, is \"x\""},
      {"1,2\n3\n", "line 2: has 1 numbers, the lines before have 2"},
      {"1 2\n3 inf\n", "line 2, column 2: is not finite"},
      {"1,2\n\"3\",4,\n5,,6\n", "line 3"},
      {"bad,2\n3,4\n", "line 1, column 1: must be a number, is \"bad\""},
      {"1,bad\n3,4\n", "line 1, column 2: must be a number, is \"bad\""}};
  for (const auto& [text, message] : cases) {
    const std::string why = why_refused([&, t = text] { numbers_of_text(t, "t"); });
    EXPECT_NE(why.find(message), std::string::npos) << why;
  }
  EXPECT_EQ(numbers_of_text("\xef\xbb\xbfname;other\r\n+1.5;2e-3\r\n", "t"),
            (RowMajorMatrix(1, 2) << 1.5, 2e-3).finished());
  // The titles that pandas gives columns without names; an order of channels is none.
  EXPECT_EQ(numbers_of_text("0,1,2,3,4,5,6,7\n1,1,1,1,1,1,1,1\n", "t"), RowMajorMatrix::Ones(1, 8));
  EXPECT_EQ(numbers_of_text("0,1,2,3,4,5,6,8\n", "t").rows(), 1);
  EXPECT_EQ(numbers_of_text("0 1\n0 2\n", "t").rows(), 2);
}

TEST(FrameReaders, ShapesThatContradictTheOrderAreRefused) {
  const TemporaryFolder folder("shapes");
  const Frames frames = channels_of_maps({});
  const auto refused = [&](std::vector<std::uint64_t> shape, const std::string& channels = "") {
    shape.insert(shape.begin(), 3);
    Hdf5File file = Hdf5File::create(folder / "frames.h5");
    file.create_dataset("/voltages", shape);
    file.write_rows("/voltages", 0, frames);
    file.close();
    return why_refused([&] { OwnFrames read(options_for(folder / "frames.h5", channels)); });
  };
  EXPECT_EQ(refused({208}), "");
  EXPECT_EQ(refused({16, 13}), "");
  EXPECT_EQ(refused({16, 13}, "rotating"), "");
  EXPECT_NE(refused({13, 16}).find("drives and measurements are exchanged"), std::string::npos);
  EXPECT_NE(refused({13, 16}, "measure-major").find("[N, 16, 13]"), std::string::npos);
  EXPECT_NE(refused({8, 26}).find("are no drives and measurements"), std::string::npos);
  EXPECT_NE(refused({208, 1}).find("as [N, 208]"), std::string::npos);
}

TEST(FrameReaders, ASquareTableMustBeDeclaredAndTurnsItsReferenceToo) {
  const TemporaryFolder folder("square");
  RowMajorMatrix table(208, 208);
  for (Eigen::Index i = 0; i < table.size(); ++i) table.data()[i] = static_cast<double>(i);
  Hdf5File file = Hdf5File::create(folder / "frames.h5");
  file.write_matrix("/voltages", table);
  file.write_matrix("/reference_voltages", 0.5 * table);
  file.close();
  OwnFramesOptions options = options_for(folder / "frames.h5");
  EXPECT_NE(why_refused([&] { OwnFrames read(options); }).find("--transposed=false"),
            std::string::npos);
  options.file.transposed = false;
  EXPECT_EQ(OwnFrames(options).changes(2, 1), 0.5 * table.row(2));
  options.file.transposed = true;
  EXPECT_EQ(OwnFrames(options).changes(2, 1), 0.5 * table.col(2).transpose());
}

TEST(FrameReaders, WrongColumnsAndOrdersAreRefusedWithARemedy) {
  const TemporaryFolder folder("wrong");
  const Sensor sensor;
  write_file(folder / "frames.csv", text_of(channels_of_maps(sensor), ","));
  write_file(folder / "few.csv", "1,2,3\n");
  write_file(folder / "turned.csv", text_of(RowMajorMatrix::Ones(208, 2), ","));
  write_file(folder / "short.txt", "0 2\n0 3\n");
  std::string twice;
  for (int c = 0; c < 208; ++c) twice += "0 2\n";
  write_file(folder / "twice.txt", twice);
  const auto refused = [&](const char* file, const std::string& channels) {
    return why_refused([&] { OwnFrames frames(options_for(folder / file, channels)); });
  };
  EXPECT_NE(refused("few.csv", "").find("[N, 208], has [1, 3]"), std::string::npos);
  EXPECT_NE(refused("turned.csv", "").find("--transposed"), std::string::npos);
  EXPECT_NE(refused("frames.csv", "full").find("[N, 256]"), std::string::npos);
  EXPECT_NE(refused("frames.csv", "drive").find("drive-major, measure-major"), std::string::npos);
  EXPECT_NE(refused("frames.csv", folder / "short.txt").find("lines for 2 columns"),
            std::string::npos);
  EXPECT_NE(refused("frames.csv", folder / "twice.txt").find("same channel as column 0"),
            std::string::npos);
  OwnFramesOptions options = options_for(folder / "frames.csv");
  options.unit = "kV";
  EXPECT_NE(why_refused([&] { OwnFrames frames(options); }).find("must be V, mV or uV"),
            std::string::npos);
}

/// A file after the instrument's format, with the potentials of the homogeneous disc: of a current
/// from `source` to `sink` on the border, I ln(|z - sink|/|z - source|) / (pi sigma).
std::string eit_of_disc(const Sensor& sensor, double offset) {
  std::ostringstream out;
  out.precision(17);
  out << "18\r\n2\r\nsetup_00001\r\n2025.02.12. 13:19:58.685\r\n10000.0\r\n10000.0\r\n1\r\n1\r\n"
      << sensor.drive_current
      << "\r\n20.0\r\n0.0\r\n1.0\r\n1\r\n1\r\n1\r\n1\r\nMeasurementChannels: ";
  for (int e = 1; e <= 16; ++e) out << (e > 1 ? "," : "") << e;
  out << "\r\nMeasurementChannelsIndependentFromInjectionPattern: ";
  for (int e = 1; e <= 18; ++e) out << (e > 1 ? "," : "") << e;
  out << "\r\n";
  const Eigen::Matrix2Xd at = electrode_positions(sensor);
  const double scale = sensor.drive_current / std::numbers::pi / sensor.background;
  for (int d = 0; d < 16; ++d) {
    // Every third injection the other way round.
    const int source = d % 3 ? (d + 1) % 16 : d;
    const int sink = d % 3 ? d : (d + 1) % 16;
    out << source + 1 << ' ' << sink + 1 << "\r\n";
    for (int e = 0; e < 18; ++e) {
      double potential = 7;  // of electrodes that are driven, or not used at all
      if (e < 16 && e != source && e != sink) {
        potential = scale * std::log((at.col(e) - at.col(sink)).norm() /
                                     (at.col(e) - at.col(source)).norm());
      }
      out << (e > 0 ? "\t" : "") << potential + offset << '\t' << -0.125;
    }
    out << "\r\n";
  }
  return out.str();
}

TEST(EitFrames, AreTheVoltagesOfTheSensor) {
  const TemporaryFolder folder("eit");
  const Sensor sensor = testing::disc_sensor();
  for (const int number : {1, 2, 10}) {
    write_file(folder / ("setup_" + std::to_string(number) + ".eit"),
               eit_of_disc(sensor, 0.01 * number));
  }
  const auto source = open_frames(folder.path(), {});
  ASSERT_EQ(source->frames(), 3u);
  EXPECT_EQ(source->columns(), 256);
  EXPECT_EQ(source->current(), sensor.drive_current);
  EXPECT_EQ(source->files().back().filename(), "setup_10.eit");
  const RowMajorMatrix raw = source->read(0, 3);
  EXPECT_NEAR(raw(2, 20) - raw(0, 20), 0.09, 1e-12);

  const ChannelMap map = channel_map(sensor, *source, "", "V");
  const Frames frames = map.apply(raw);
  const Eigen::VectorXd expected = BorderModel(sensor).reference_voltages();
  for (Eigen::Index f = 0; f < 3; ++f) {
    EXPECT_LT((frames.row(f).transpose() - expected).norm(), 1e-10 * expected.norm());
  }
}

TEST(EitFrames, DamagedFilesAreRefusedWithTheirLine) {
  const std::string good = eit_of_disc(testing::disc_sensor(), 0);
  EXPECT_EQ(parse_eit(good, "f").injections.size(), 16u);
  EXPECT_EQ(parse_eit(good, "f").electrodes.size(), 16u);
  const auto damaged = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return why_refused([&] { parse_eit(text, "f"); });
  };
  EXPECT_NE(damaged("18\r\n", "x\r\n").find("f: line 1: "), std::string::npos);
  EXPECT_NE(damaged("18\r\n", "900\r\n").find("f: line"), std::string::npos);
  EXPECT_NE(damaged("\r\n1\r\n1\r\n", "\r\n1\r\n0\r\n").find("the number of frequencies"),
            std::string::npos);
  EXPECT_NE(damaged("1 2\r\n", "1 2 3\r\n").find("f: line 19: "), std::string::npos);
  EXPECT_NE(damaged("-0.125\r\n", "-0.125\t2\r\n").find("f: line 20: must hold real and imaginary"),
            std::string::npos);
  EXPECT_NE(damaged("-0.125\t", "nan\t").find("finite numbers"), std::string::npos);
  EXPECT_NE(why_refused([&] { parse_eit(good.substr(0, good.size() / 2), "f"); }).find("f: line"),
            std::string::npos);
  EXPECT_NE(why_refused([&] { parse_eit("", "f"); }).find("f: line 0"), std::string::npos);

  const TemporaryFolder folder("eit");
  EXPECT_NE(why_refused([&] { open_frames(folder.path(), {}); }).find("without .eit files"),
            std::string::npos);
}

}  // namespace
}  // namespace ertbench
