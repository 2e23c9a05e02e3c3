// What a stream of frames goes through before and after the solver.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/errors.h"
#include "core/json.h"
#include "core/random.h"
#include "core/statistics.h"
#include "forward/sheet/sensor.h"
#include "live/line_output.h"
#include "live/live_server.h"
#include "live/live_source.h"
#include "live/live_state.h"

namespace ertbench {
namespace {

class Collected : public FrameSink {
 public:
  void frame(std::span<const double> voltages) override {
    frames.emplace_back(voltages.begin(), voltages.end());
  }
  void damaged(Damage damage) override { ++damages[static_cast<std::size_t>(damage)]; }
  int damages_of(Damage damage) const { return damages[static_cast<std::size_t>(damage)]; }

  std::vector<std::vector<double>> frames;
  std::array<int, all_damages.size()> damages{};
};

constexpr int channels = 4;

std::string bytes_of(const std::vector<double>& values) {
  std::string out(sizeof(double) * values.size(), '\0');
  std::memcpy(out.data(), values.data(), out.size());
  return out;
}

/// Three frames whose values differ, exactly what a line of text can carry.
std::vector<std::vector<double>> three_frames() {
  return {{0.125, -2, 3e-5, 4}, {5, 6, -7.25, 8}, {1e-300, 0, -0.5, 999}};
}

std::string lines_of(const std::vector<std::vector<double>>& frames, const char* separator) {
  std::string out;
  for (const auto& frame : frames) {
    for (std::size_t i = 0; i < frame.size(); ++i) {
      char text[40];
      std::snprintf(text, sizeof text, "%s%.17g", i > 0 ? separator : "", frame[i]);
      out += text;
    }
    out += "\r\n";
  }
  return out;
}

TEST(FrameParser, FindsFramesHoweverTheBytesAreCut) {
  std::string binary;
  for (const auto& frame : three_frames()) binary += bytes_of(frame);
  for (const std::string& bytes :
       {binary, lines_of(three_frames(), ","), lines_of(three_frames(), "; "),
        "a,b,c,d\n# remark\n\n" + lines_of(three_frames(), "\t")}) {
    for (std::size_t cut = 1; cut <= bytes.size(); ++cut) {
      Collected sink;
      FrameParser parser(channels, FrameFormat::detect);
      for (std::size_t at = 0; at < bytes.size(); at += cut) {
        parser.feed(std::string_view(bytes).substr(at, cut), sink);
      }
      parser.end(sink);
      EXPECT_EQ(sink.frames, three_frames()) << "cut into pieces of " << cut;
      EXPECT_EQ(sink.damages, (std::array<int, 3>{})) << cut;
    }
  }
}

TEST(FrameParser, CountsDamagedLinesAndGoesOn) {
  Collected sink;
  FrameParser parser(channels, FrameFormat::csv);
  const std::string good = lines_of(three_frames(), ",");
  parser.feed("1,2,3\n" + good + "1,2,3,4,5\n1,x,3,4\n1,2,3,nan\n1,2,3,1e999\n1,2,3,1001\n" + good,
              sink);
  parser.feed("1,2,3,", sink);
  parser.end(sink);
  EXPECT_EQ(sink.frames.size(), 6u);
  EXPECT_EQ(sink.damages_of(Damage::length), 3);
  EXPECT_EQ(sink.damages_of(Damage::text), 1);
  EXPECT_EQ(sink.damages_of(Damage::value), 3);
}

TEST(FrameParser, OnlyAFirstLineWithoutNumbersIsOneOfTitles) {
  for (const auto& [first, damaged] :
       {std::pair("a,b,c,d\n", 0), {"bad,2,3,4\n", 1}, {"\"x\",2,3,4\n", 1}}) {
    Collected sink;
    FrameParser parser(channels, FrameFormat::csv);
    parser.feed(first + lines_of(three_frames(), ","), sink);
    EXPECT_EQ(sink.frames, three_frames()) << first;
    EXPECT_EQ(sink.damages_of(Damage::text), damaged) << first;
  }
}

TEST(FrameParser, ALineWithoutAnEndIsGivenUp) {
  Collected sink;
  FrameParser parser(channels, FrameFormat::csv);
  for (int i = 0; i < 10000; ++i) parser.feed("1,2,3,4,5,6,7,8,", sink);
  parser.feed("9\n1,2,3,4\n", sink);
  EXPECT_EQ(sink.frames.size(), 1u);
  EXPECT_EQ(sink.damages_of(Damage::length), 1);
}

TEST(FrameParser, APauseIsWhereBinaryFramesBeginAnew) {
  Collected sink;
  FrameParser parser(channels, FrameFormat::binary);
  parser.feed(bytes_of({1, 2, 3}), sink);
  parser.pause(sink);
  parser.feed(bytes_of({5, 6, 7, 8}), sink);
  parser.pause(sink);
  EXPECT_EQ(sink.frames, (std::vector<std::vector<double>>{{5, 6, 7, 8}}));
  EXPECT_EQ(sink.damages_of(Damage::length), 1);
}

TEST(FrameParser, BinaryValuesMustBeVoltages) {
  Collected sink;
  FrameParser parser(channels, FrameFormat::binary);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e9}) {
    parser.feed(bytes_of({1, bad, 3, 4}), sink);
  }
  EXPECT_TRUE(sink.frames.empty());
  EXPECT_EQ(sink.damages_of(Damage::value), 3);
}

TEST(FrameParser, ADatagramIsAFrameOrNothing) {
  Collected sink;
  FrameParser parser(channels, FrameFormat::detect);
  parser.datagram(bytes_of({1, 2, 3, 4}), sink);
  parser.datagram("1 2 3 4\n", sink);
  for (const std::string& wrong : {bytes_of({1, 2, 3}), bytes_of({1, 2, 3, 4, 5}), std::string()}) {
    parser.datagram(wrong, sink);
  }
  EXPECT_EQ(sink.frames.size(), 2u);
  EXPECT_EQ(sink.damages_of(Damage::length), 3);
}

ArrivedFrame numbered(std::uint64_t number) { return {number, {}, {}}; }

TEST(Mailbox, TheNewestWins) {
  using std::chrono::milliseconds;
  Mailbox box(1, false);
  ArrivedFrame frame;
  EXPECT_EQ(box.take(frame, milliseconds(1)), Mailbox::Taken::nothing);
  for (std::uint64_t n = 0; n < 5; ++n) box.put(numbered(n));
  EXPECT_EQ(box.take(frame, milliseconds(1)), Mailbox::Taken::frame);
  EXPECT_EQ(frame.number, 4u);
  EXPECT_EQ(box.dropped(), 4u);
  box.put(numbered(5));
  box.close();
  EXPECT_FALSE(box.put(numbered(6)));
  EXPECT_EQ(box.take(frame, milliseconds(1)), Mailbox::Taken::frame);
  EXPECT_EQ(box.take(frame, milliseconds(1)), Mailbox::Taken::closed);
}

TEST(Mailbox, LosslessTheReaderWaits) {
  Mailbox box(2, true);
  std::thread reader([&] {
    for (std::uint64_t n = 0; n < 1000; ++n) box.put(numbered(n));
    box.close();
  });
  ArrivedFrame frame;
  std::uint64_t next = 0;
  while (box.take(frame, std::chrono::seconds(60)) == Mailbox::Taken::frame) {
    EXPECT_EQ(frame.number, next++);
  }
  reader.join();
  EXPECT_EQ(next, 1000u);
  EXPECT_EQ(box.dropped(), 0u);
}

TEST(Mailbox, ClosingLetsAWaitingReaderGo) {
  Mailbox box(1, true);
  box.put(numbered(0));
  std::thread reader([&] { EXPECT_FALSE(box.put(numbered(1))); });
  box.close(true);
  reader.join();
  EXPECT_EQ(box.dropped(), 1u);
}

// A class is 10^(1/100) wide, so that its upper end is at most 2.33 % above the exact quantile.
TEST(LatencyHistogram, QuantilesAreThoseOfTheValuesButForTheClassWidth) {
  RandomStream random(5, 1, 0, Purpose::scene);
  LatencyHistogram histogram;
  std::vector<double> values;
  for (int i = 0; i < 5000; ++i) {
    values.push_back(1e-4 * std::exp(1.5 * random.normal()));
    histogram.add(values.back());
  }
  const SortedValues sorted(values);
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const double exact = nearest_rank_quantile(sorted, share);
    EXPECT_GE(*histogram.quantile_s(share), exact * (1 - 1e-12)) << share;
    EXPECT_LE(*histogram.quantile_s(share), exact * std::pow(10, 0.01) * (1 + 1e-12)) << share;
  }
  EXPECT_EQ(*histogram.quantile_s(1), sorted.largest());
  std::uint64_t all = 0;
  for (const std::uint64_t count : histogram.coarse(10)) all += count;
  EXPECT_EQ(all, 5000u);
  EXPECT_FALSE(LatencyHistogram().quantile_s(0.5));
}

TEST(InputPlace, ReadsAllForms) {
  EXPECT_EQ(input_place("-").kind, InputPlace::Kind::standard_input);
  const InputPlace udp = input_place("udp://[::1]:9000");
  EXPECT_EQ(udp.name, "::1");
  EXPECT_EQ(udp.port, 9000);
  const InputPlace serial = input_place("serial:/dev/ttyACM0@921600");
  EXPECT_EQ(serial.name, "/dev/ttyACM0");
  EXPECT_EQ(serial.baud, 921600);
  const InputPlace replay = input_place("replay:a@b.h5@62.5");
  EXPECT_EQ(replay.name, "a@b.h5");
  EXPECT_EQ(replay.rate, 62.5);
  EXPECT_FALSE(input_place("replay:a@b.h5").rate);
  for (const char* wrong : {"", "frames.h5", "udp://:9000", "udp://127.0.0.1", "udp://h:70000",
                            "replay:a.h5@0", "replay:a.h5@-3", "serial:a@nan"}) {
    EXPECT_THROW(input_place(wrong), InputError) << wrong;
  }
}

TEST(LiveState, SaysWhatTheSheetLooksLike) {
  const auto state_of = [](const char* sensor) {
    const nlohmann::json spec = nlohmann::json::parse(sensor);
    LiveHeading heading;
    heading.sensor = sensor_from_json(JsonObject(spec, "", ""));
    return nlohmann::json::parse(LiveState(heading).json());
  };
  const nlohmann::json rectangle =
      state_of(R"({"shape": "rectangle", "sides_mm": [300, 150], "electrode_count": 32})");
  EXPECT_EQ(rectangle.at("outline"),
            (nlohmann::json{{-150.0, -75.0}, {150.0, -75.0}, {150.0, 75.0}, {-150.0, 75.0}}));
  EXPECT_EQ(rectangle.at("size_mm"), (nlohmann::json{300.0, 150.0}));
  EXPECT_EQ(rectangle.at("electrodes").size(), 32U);
  // [rows, columns], of square pixels.
  EXPECT_EQ(2 * rectangle.at("image_size").at(0).get<int>(), rectangle.at("image_size").at(1));
  const nlohmann::json disc = state_of(R"({"shape": "disc", "diameter_mm": 100})");
  EXPECT_GT(disc.at("outline").size(), 40U);
  for (const char* places : {"outline", "electrodes"}) {
    for (const nlohmann::json& place : disc.at(places)) {
      // Places are rounded to three digits.
      EXPECT_NEAR(std::hypot(place.at(0).get<double>(), place.at(1).get<double>()), 50, 0.1);
    }
  }
}

TEST(LiveServer, KnowsWhatOnlyThisMachineReaches) {
  for (const char* own : {"127.0.0.1", "127.1.2.3", "localhost", "::1"}) {
    EXPECT_TRUE(is_loopback(own)) << own;
  }
  for (const char* other : {"0.0.0.0", "192.168.1.2", "::", "evil.example", "127.evil.example",
                            "127.0.0.1.evil.example"}) {
    EXPECT_FALSE(is_loopback(other)) << other;
  }
}

}  // namespace
}  // namespace ertbench
