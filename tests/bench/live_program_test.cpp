// `ertbench live` as users call it: every kind of input, and everything that may happen to one.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/socket.h>

#include <random>
#include <thread>

#include "core/statistics.h"
#include "forward/border/border_model.h"
#include "forward/sheet/sensor.h"
#include "tests/bench/live_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// No file of the stream's is left beside its record.
void expect_closed(const fs::path& folder, const std::string& record) {
  EXPECT_TRUE(fs::exists(folder / record));
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    EXPECT_FALSE(name.starts_with(record) && name != record) << name << " is left";
  }
}

/// The program between words of the shell.
fs::path wrapped(const LiveFolder& folder, const std::string& before, const std::string& after) {
  const fs::path script = folder / "wrapped";
  write_text(script, "#!/bin/sh\n" + before + " " + quoted(ERTBENCH_PROGRAM) + " \"$@\" " + after);
  fs::permissions(script, fs::perms::owner_all);
  return script;
}

TEST(LiveProgram, ImagesAreThoseOfReconstruct) {
  const LiveFolder folder;
  const Outcome images = run_program(
      folder.path(), "reconstruct --solver gn.json --input frames.h5 --output images.h5");
  ASSERT_EQ(images.exit_code, 0) << images.output;
  const Outcome live = run_program(folder.path(),
                                   "live --solver gn.json --input replay:frames.h5 --lossless "
                                   "--record record.h5");
  ASSERT_EQ(live.exit_code, 0) << live.output;
  expect_closed(folder.path(), "record.h5");
  const Hdf5File expected = Hdf5File::open(folder / "images.h5");
  const Hdf5File record = Hdf5File::open(folder / "record.h5");
  // One frame at a time or all at once: sums in another order.
  const RowMajorMatrix a = expected.read_rows("/conductivity_change", 0, 40);
  const RowMajorMatrix b = record.read_rows("/answer/conductivity_change", 0, 40);
  EXPECT_LT((a - b).norm(), 1e-10 * a.norm());
  EXPECT_EQ(expected.read_rows("/status", 0, 40), record.read_rows("/answer/status", 0, 40));
  EXPECT_EQ(record.read_rows("/voltages", 0, 40), folder.voltages);
  for (Eigen::Index f = 0; f < 40; ++f) {
    EXPECT_EQ(record.read_rows("/answer/frame", 0, 40)(f, 0), static_cast<double>(f));
  }
}

TEST(LiveProgram, ARecordCanBeReplayedAndReconstructed) {
  const LiveFolder folder;
  const std::string live = "live --solver gn.json --lossless --record record.h5 --input replay:";
  ASSERT_EQ(run_program(folder.path(), live + "frames.h5").exit_code, 0);
  const Outcome images = run_program(
      folder.path(), "reconstruct --solver gn.json --input record.h5 --output images.h5");
  EXPECT_EQ(images.exit_code, 0) << images.output;
  // Over a record of its own, and nothing else.
  EXPECT_EQ(run_program(folder.path(), live + "frames.h5").exit_code, 0);
  const Outcome refused = run_program(
      folder.path(), "live --solver gn.json --input replay:record.h5 --record frames.h5");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.output.find("frames.h5"), std::string::npos) << refused.output;
  const auto before = fs::file_size(folder / "record.h5");
  const Outcome over_itself = run_program(
      folder.path(), "live --solver gn.json --input replay:record.h5 --record ./record.h5");
  EXPECT_EQ(over_itself.exit_code, 2);
  EXPECT_NE(over_itself.output.find("record.h5"), std::string::npos) << over_itself.output;
  EXPECT_EQ(fs::file_size(folder / "record.h5"), before);
}

TEST(LiveProgram, WhatADiskRefusesIsSaidAndNothingThatCameIsLost) {
  const LiveFolder folder;
  // Room for the voltages of some frames, for the images of fewer, and not for the file of both.
  const Outcome outcome = run_program(
      folder.path(), "live --solver gn.json --input replay:frames.h5 --lossless --record record.h5",
      wrapped(folder, "trap '' XFSZ; ulimit -f 48; exec", ""));
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_NE(outcome.output.find("the disk refuses rows"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("what came stays as rows of 210 doubles"), std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("\"event\":\"end\""), std::string::npos) << outcome.output;
  EXPECT_FALSE(fs::exists(folder / "record.h5"));
  int kept = 0;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    if (entry.path().extension() != ".frames") continue;
    ++kept;
    std::ifstream in(entry.path(), std::ios::binary);
    std::vector<double> row(210);
    in.read(reinterpret_cast<char*>(row.data()), 210 * sizeof(double));
    for (Eigen::Index c = 0; c < 208; ++c) {
      EXPECT_EQ(row[static_cast<std::size_t>(2 + c)], folder.voltages(0, c));
    }
  }
  EXPECT_EQ(kept, 1);
}

TEST(LiveProgram, AnOutputThatCannotBeWrittenIsAFailure) {
  const LiveFolder folder;
  const Outcome outcome =
      run_program(folder.path(), "live --solver gn.json --input replay:frames.h5 --lossless",
                  wrapped(folder, "exec", "> /dev/full"));
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_NE(outcome.output.find("standard output cannot be written: No space left"),
            std::string::npos)
      << outcome.output;
}

TEST(LiveProgram, AReaderThatIsSlowHasTheEndToo) {
  const LiveFolder folder;
  RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input",
                                         "replay:frames.h5@500", "--repeat", "1000", "--images"});
  ASSERT_FALSE(program.event("begin").is_null()) << program.errors();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until the pipe is full
  program.signal(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const std::vector<json> lines = program.lines();
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  EXPECT_EQ(lines.back().at("event"), "end");
}

TEST(LiveProgram, BinaryFramesAndLinesComeToTheSame) {
  const LiveFolder folder;
  std::vector<std::vector<json>> found;
  for (const bool binary : {true, false}) {
    RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input", "-",
                                           "--reference", "frames.h5", "--lossless"});
    for (Eigen::Index f = 0; f < 10; ++f) program.write(binary ? folder.binary(f) : folder.csv(f));
    program.close_input();
    const std::vector<json> lines = program.lines();
    EXPECT_EQ(program.exit_code(), 0) << program.errors();
    ASSERT_FALSE(lines.empty());
    EXPECT_EQ(lines.front().at("event"), "begin");
    EXPECT_EQ(lines.back().at("event"), "end");
    EXPECT_EQ(lines.back().at("answered"), 10);
    found.push_back(contacts_of(lines));
  }
  EXPECT_EQ(found[0].size(), 10u);
  EXPECT_EQ(found[0], found[1]);
}

TEST(LiveProgram, AnswersAreSentAsDatagrams) {
  const LiveFolder folder;
  const Outcome outcome = run_program(folder.path(),
                                      ERTBENCH_SOURCE_DIR "/tests/live/datagrams.py " +
                                          quoted(ERTBENCH_PROGRAM) + " frames.h5 gn.json",
                                      "/usr/bin/python3");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(run_program(folder.path(),
                        "live --solver gn.json --input replay:frames.h5 --send 127.0.0.1:9")
                .output.find("--send: must be udp://HOST:PORT"),
            std::string::npos);
}

TEST(LiveProgram, DamagedFramesAreCountedAndPassedOver) {
  const LiveFolder folder;
  RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input", "-",
                                         "--reference", "frames.h5", "--lossless"});
  std::string no_number = folder.csv(1);
  no_number.replace(0, no_number.find(','), "nan");
  program.write(folder.csv(0) + "0.1,0.2\n" + "garbage \x01\xff\n" + no_number + folder.csv(2));
  const json damage = program.event("damaged");
  ASSERT_FALSE(damage.is_null()) << program.errors();
  program.close_input();
  const std::vector<json> lines = program.lines();
  EXPECT_EQ(program.exit_code(), 0);
  EXPECT_EQ(lines.back().at("came"), 2);
  EXPECT_EQ(lines.back().at("answered"), 2);
  EXPECT_EQ(lines.back().at("damaged"),
            (json{{"wrong length", 1}, {"not numbers", 1}, {"not voltages", 1}}));
}

TEST(LiveProgram, ADeadSenderIsSaidAndSoIsItsReturn) {
  const LiveFolder folder;
  RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input", "-",
                                         "--reference", "frames.h5", "--silence", "0.3"});
  program.write(folder.csv(0));
  const json silence = program.event("silence");
  ASSERT_FALSE(silence.is_null());
  EXPECT_GE(silence.at("silent_s").get<double>(), 0.3);
  EXPECT_NE(program.errors().find("is the sender alive?"), std::string::npos);
  program.write(folder.csv(1));
  EXPECT_FALSE(program.event("resumed").is_null());
}

TEST(LiveProgram, TheFirstFramesMayBeTheReference) {
  const LiveFolder folder;
  RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input", "-",
                                         "--background", "3", "--lossless", "--images"});
  // The mean of the first three frames is the first frame: of equal voltages there is no change.
  for (const Eigen::Index f : {0, 0, 0, 0, 1}) program.write(folder.binary(f));
  program.close_input();
  const std::vector<json> answers = answers_of(program.lines());
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  ASSERT_EQ(answers.size(), 2u);
  double largest[2] = {};
  for (std::size_t a = 0; a < 2; ++a) {
    for (const double change : answers[a].at("image")) {
      largest[a] = std::max(largest[a], std::abs(change));
    }
  }
  EXPECT_LT(largest[0], 1e-9 * largest[1]);
}

TEST(LiveProgram, TheFirstFramesAreAllTakenThoughTheyComeAtOnce) {
  const LiveFolder folder;
  for (const int sent : {3, 20}) {
    RunningProgram program(folder.path(),
                           {"live", "--solver", "gn.json", "--input", "-", "--background", "20"});
    std::string burst;
    for (int f = 0; f < sent; ++f) burst += folder.binary(0);
    program.write(burst);
    program.close_input();
    const bool enough = sent == 20;
    EXPECT_EQ(program.exit_code(), enough ? 0 : 2) << program.errors();
    const std::string said = enough ? "" : "the input ended after 3 of them";
    EXPECT_NE(program.errors().find(said), std::string::npos) << program.errors();
  }
}

TEST(LiveProgram, ContactsTakeTheirNoiseFromTheFirstFrames) {
  const TemporaryFolder folder("live");
  write_text(folder / "contacts.json", R"({"type": "contacts"})");
  const Sensor sensor;
  const BorderModel model(sensor);
  Contact disc;
  disc.centre = {0.35, -0.2};
  disc.half_size = {0.15, 0.15};
  disc.conductivity_ratio = 0.4;
  const Eigen::VectorXd& reference = model.reference_voltages();
  const Eigen::VectorXd touched = reference + model.solve_at({{disc}}, 1).change;
  RunningProgram program(folder.path(), {"live", "--solver", "contacts.json", "--input", "-",
                                         "--background", "20", "--lossless"});
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1e-4 * reference.cwiseAbs().mean());
  for (int f = 0; f < 22; ++f) {
    std::string line;
    for (const double value : f == 20 ? touched : reference) {
      line += (line.empty() ? "" : ",") + json(value + noise(random)).dump();
    }
    program.write(line + "\n");
  }
  program.close_input();
  const std::vector<json> answers = answers_of(program.lines());
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  ASSERT_EQ(answers.size(), 2u);
  ASSERT_EQ(answers[0].at("contacts").size(), 1u);
  const json& contact = answers[0].at("contacts")[0];
  const double mm = sensor.sheet->unit_mm();
  EXPECT_NEAR(contact.at("x_mm").get<double>(), 0.35 * mm, 0.02 * mm);
  EXPECT_NEAR(contact.at("y_mm").get<double>(), -0.2 * mm, 0.02 * mm);
  EXPECT_EQ(answers[0].at("status"), "ok");
  EXPECT_TRUE(answers[1].at("contacts").empty());
}

TEST(LiveProgram, UnitsAndOrdersAreDeclaredAndCheckedAsByReconstruct) {
  const LiveFolder folder;
  const Sensor sensor;
  const Eigen::RowVectorXd reference =
      Hdf5File::open(folder / "frames.h5").read_vector("/reference_voltages").transpose();
  // Three frames without contact, then one, by full maps in mV.
  const std::vector<int> drives_and_measurements = [&] {
    std::vector<int> places;
    const auto measurements = static_cast<int>(measurement_pairs(sensor).size());
    for (const Channel& channel : channels_of(sensor)) {
      places.push_back(channel.drive * measurements + channel.measurement);
    }
    return places;
  }();
  const auto line = [&](const Eigen::RowVectorXd& voltages, double factor, bool full) {
    std::vector<double> values(full ? drive_pairs(sensor).size() * measurement_pairs(sensor).size()
                                    : static_cast<std::size_t>(voltages.size()));
    for (Eigen::Index c = 0; c < voltages.size(); ++c) {
      const auto place =
          full ? drives_and_measurements[static_cast<std::size_t>(c)] : static_cast<int>(c);
      values[static_cast<std::size_t>(place)] = factor * voltages[c];
    }
    std::string out;
    for (const double value : values) out += (out.empty() ? "" : ",") + std::to_string(value);
    return out + "\n";
  };
  const auto run = [&](const std::vector<std::string>& more,
                       const std::vector<std::string>& lines) {
    std::vector<std::string> arguments = {"live", "--solver",     "gn.json", "--input",
                                          "-",    "--background", "3",       "--lossless"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    RunningProgram program(folder.path(), arguments);
    for (const std::string& text : lines) program.write(text);
    program.close_input();
    const std::vector<json> answers = answers_of(program.lines());
    const int code = program.exit_code();
    return std::tuple(answers, code, program.errors());
  };
  const auto lines = [&](double factor, bool full) {
    std::vector<std::string> out(3, line(reference, factor, full));
    out.push_back(line(folder.voltages.row(1), factor, full));
    return out;
  };
  const auto [right, code, errors] = run({"--channels", "full", "--unit", "mV"}, lines(1e3, true));
  EXPECT_EQ(code, 0) << errors;
  ASSERT_EQ(right.size(), 1u) << errors;
  EXPECT_EQ(right[0].at("status"), "ok") << right[0];

  const auto [none, wrong, why] = run({}, lines(1e3, false));
  EXPECT_EQ(wrong, 2);
  EXPECT_TRUE(none.empty());
  EXPECT_NE(why.find("millivolts for volts"), std::string::npos) << why;
  const auto [mended, fixed_code, said] = run({"--fix"}, lines(1e3, false));
  EXPECT_EQ(fixed_code, 0) << said;
  ASSERT_EQ(mended.size(), 1u) << said;
  EXPECT_EQ(mended[0].at("status"), "ok");
  EXPECT_NEAR(mended[0].at("signal").get<double>(), right[0].at("signal").get<double>(),
              0.02 * right[0].at("signal").get<double>());

  // The unit of a single frame.
  std::vector<std::string> mixed = lines(1, false);
  mixed.back() = lines(1e3, false).back();
  const auto [flagged, ended, log] = run({}, mixed);
  EXPECT_EQ(ended, 0) << log;
  ASSERT_EQ(flagged.size(), 1u) << log;
  EXPECT_EQ(flagged[0].at("status"), "suspect");
  EXPECT_EQ(flagged[0].at("reasons"), json({"impossible level"}));
}

/// A port of UDP that nobody has at this moment.
int free_port() {
  const int probe = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(probe, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(probe);
  return ntohs(address.sin_port);
}

void send_datagram(int port, const std::string& bytes) {
  const int sender = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ::sendto(sender, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&address),
           sizeof address);
  ::close(sender);
}

TEST(LiveProgram, ADatagramOfAWrongSizeIsDropped) {
  const LiveFolder folder;
  const int port = free_port();
  RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input",
                                         "udp://127.0.0.1:" + std::to_string(port), "--reference",
                                         "frames.h5", "--queue", "100", "--record", "record.h5"});
  ASSERT_FALSE(program.event("begin").is_null()) << program.errors();
  send_datagram(port, folder.binary(0));
  send_datagram(port, folder.binary(1).substr(8));
  send_datagram(port, folder.binary(1) + "12345678");
  send_datagram(port, "");
  send_datagram(port, folder.csv(2));
  json answer = json::object();
  while (answer.value("frame", -1) != 1) {
    const auto line = program.line();
    ASSERT_TRUE(line) << program.errors();
    answer = json::parse(*line);
  }
  program.signal(SIGTERM);
  const std::vector<json> lines = program.lines();
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  EXPECT_EQ(lines.back().at("came"), 2);
  EXPECT_EQ(lines.back().at("damaged").at("wrong length"), 3);
  EXPECT_EQ(lines.back().at("why"), "it was told to end");
  expect_closed(folder.path(), "record.h5");
  const Hdf5File record = Hdf5File::open(folder / "record.h5");
  EXPECT_EQ(record.read_rows("/voltages", 0, 1), folder.voltages.topRows(1));
}

TEST(LiveProgram, ASerialLineMayBeginInTheMiddleAndDisappear) {
  const LiveFolder folder;
  const int line = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(line, 0);
  ASSERT_EQ(::grantpt(line) + ::unlockpt(line), 0);
  const std::string device = ::ptsname(line);
  RunningProgram program(folder.path(),
                         {"live", "--solver", "gn.json", "--input", "serial:" + device + "@921600",
                          "--reference", "frames.h5", "--queue", "100", "--record", "record.h5"});
  ASSERT_FALSE(program.event("begin").is_null()) << program.errors();
  const std::string text = folder.csv(0).substr(500) + folder.csv(1) + folder.csv(2);
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t n = ::write(line, text.data() + at, std::min<std::size_t>(512, text.size() - at));
    ASSERT_GT(n, 0);
    at += static_cast<std::size_t>(n);
  }
  json answer = json::object();
  while (answer.value("frame", -1) != 1) {
    const auto next = program.line();
    ASSERT_TRUE(next) << program.errors();
    answer = json::parse(*next);
  }
  ::close(line);
  const std::vector<json> lines = program.lines();
  EXPECT_EQ(program.exit_code(), 2);
  EXPECT_NE(program.errors().find(device + ": is gone"), std::string::npos) << program.errors();
  EXPECT_EQ(lines.back().at("came"), 2);
  EXPECT_EQ(lines.back().at("damaged").at("wrong length"), 1);
  expect_closed(folder.path(), "record.h5");
}

TEST(LiveProgram, SignalsEndItWithItsRecord) {
  const LiveFolder folder;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    SCOPED_TRACE(signal);
    RunningProgram program(folder.path(),
                           {"live", "--solver", "gn.json", "--input", "replay:frames.h5@100",
                            "--repeat", "1000", "--record", "record.h5"});
    ASSERT_FALSE(program.event("begin").is_null()) << program.errors();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(program.line());
    program.signal(signal);
    const std::vector<json> lines = program.lines();
    EXPECT_EQ(program.exit_code(), 0) << program.errors();
    EXPECT_EQ(lines.back().at("event"), "end");
    expect_closed(folder.path(), "record.h5");
    const Hdf5File record = Hdf5File::open(folder / "record.h5");
    EXPECT_EQ(record.shape("/voltages")[0], lines.back().at("came").get<std::uint64_t>());
    EXPECT_EQ(record.shape("/answer/frame")[0], lines.back().at("answered").get<std::uint64_t>());
  }
}

TEST(LiveProgram, AReaderThatGoesAwayEndsIt) {
  const LiveFolder folder;
  RunningProgram program(
      folder.path(), {"live", "--solver", "gn.json", "--input", "replay:frames.h5@100", "--repeat",
                      "1000", "--record", "record.h5"});
  ASSERT_FALSE(program.event("begin").is_null()) << program.errors();
  ASSERT_TRUE(program.line());
  program.close_output();
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  EXPECT_NE(program.errors().find("nobody reads"), std::string::npos) << program.errors();
  expect_closed(folder.path(), "record.h5");
}

TEST(LiveProgram, AReaderThatStopsReadingDoesNotKeepItFromEnding) {
  const LiveFolder folder;
  RunningProgram program(
      folder.path(), {"live", "--solver", "gn.json", "--input", "replay:frames.h5@500", "--repeat",
                      "1000", "--images", "--record", "record.h5"});
  ASSERT_FALSE(program.event("begin").is_null()) << program.errors();
  ASSERT_TRUE(program.line());
  // A pipe holds 64 kB, which are six of these lines.
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  EXPECT_NE(program.errors().find("it was told to end"), std::string::npos) << program.errors();
  expect_closed(folder.path(), "record.h5");
}

TEST(LiveProgram, WhatCannotBeUsedIsRefusedWithTheRemedy) {
  const LiveFolder folder;
  write_text(folder / "text.h5", "no HDF5");
  const std::string gn = "live --solver gn.json ";
  const std::pair<std::string, std::string> cases[] = {
      {gn + "--input frames.h5", "--input: must be -, udp://HOST:PORT"},
      {gn + "--input replay:absent.h5", "absent.h5: does not exist"},
      {gn + "--input replay:text.h5", "text.h5: cannot be opened as HDF5"},
      {gn + "--input replay:frames.h5@0", "must be > 0"},
      {gn + "--input serial:/dev/null@77 --reference model", "no baud rate of 77; there are 9600"},
      {gn + "--input serial:/dev/null --reference model", "/dev/null: is no serial line"},
      {gn + "--input udp://127.0.0.1:9 --lossless --reference model", "--lossless"},
      {gn + "--input udp://192.0.2.1:9000 --reference model", "cannot be listened at"},
      {gn + "--input -", "give --background N"},
      {gn + "--input - --reference frames.h5 --background 3", "--background and --reference"},
      {gn + "--input replay:frames.h5 --http 8080", "--http: must be HOST:PORT"},
      {gn + "--input replay:frames.h5 --http 192.0.2.1:80", "cannot be listened at"},
      {gn + "--input replay:frames.h5 --quiet frames.h5", "frames.h5@RATE"},
      {gn + "--input replay:frames.h5 --forces frames.h5", "no frame with one touch"},
      {gn + "--input replay:frames.h5 --record /proc/nowhere/r.h5",
       "there is no folder /proc/nowhere"},
      {"live --solver absent.json --input replay:frames.h5", "absent.json"},
      {"live --input -", "--solver is required"},
  };
  for (const auto& [arguments, part] : cases) {
    const Outcome outcome = run_program(folder.path(), arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << "\n" << outcome.output;
    EXPECT_NE(outcome.output.find(part), std::string::npos) << arguments << "\n" << outcome.output;
  }
}

}  // namespace
}  // namespace ertbench
