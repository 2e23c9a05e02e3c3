#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What is wrong, or nothing.
template <typename Function>
std::string refusal_of(Function&& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string parse_refusal(const std::string& text) {
  return refusal_of([&] { parse_json(text, "x.json"); });
}

std::string nested(int levels) { return std::string(levels, '[') + std::string(levels, ']'); }

TEST(JsonText, NestingIsBoundedBeforeTheLibraryWalksThroughIt) {
  EXPECT_EQ(parse_refusal(nested(64)), "");
  const std::string said = "x.json: is nested deeper than 64 arrays and objects";
  EXPECT_EQ(parse_refusal(nested(65)).substr(0, said.size()), said);
  EXPECT_EQ(parse_refusal(nested(70000)).substr(0, said.size()), said);
  std::string objects;
  for (int i = 0; i < 70000; ++i) objects += R"({"a":)";
  EXPECT_EQ(parse_refusal(objects).substr(0, said.size()), said);
}

TEST(JsonText, BracketsWithinStringsAreNoNesting) {
  const std::string text = "[\"" + std::string(100, '[') + "\\\"" + std::string(100, '{') + "\"]";
  EXPECT_EQ(parse_refusal(text), "");
}

TEST(JsonText, SizeIsBounded) {
  EXPECT_EQ(refusal_of([] { parse_json("[1, 2, 3]", "x.json", 8); }).find("x.json: is "), 0U);
  EXPECT_EQ(refusal_of([] { parse_json("[1, 2, 3]", "x.json", 9); }), "");
  EXPECT_EQ(refusal_of([] { require_json_size(3328599655, "x.json", most_json_bytes); }),
            "x.json: is 3.1 GB of JSON, more than 64 MB; check that it is the right one");
}

TEST(JsonText, AFileTooLargeIsNotReadAtAll) {
  const TemporaryFolder folder("json");
  std::ofstream(folder / "large.json") << "{}";
  fs::resize_file(folder / "large.json", std::uintmax_t{1} << 40U);  // of holes
  EXPECT_NE(refusal_of([&] { read_json_file(folder / "large.json"); }).find("1.02e+03 GB of JSON"),
            std::string::npos);
}

TEST(JsonText, IsWrittenWhateverItsStringsAre) {
  EXPECT_EQ(json_text({{"a", "\xff"}}), "{\"a\":\"\ufffd\"}");
  EXPECT_EQ(json_text({1, 2}, 0), "[\n1,\n2\n]");
}

TEST(JsonText, StringsAndKeysBecomePrintable) {
  const json value = {{"a\x1b[31m", {"b\xff", 1.5, nullptr}}};
  EXPECT_EQ(printable_json(value), json({{"a\ufffd[31m", {"b\ufffd", 1.5, nullptr}}}));
}

TEST(JsonText, MessagesShowAtMostSoMuchOfAValueAndOfAKey) {
  const json value = {{std::string(5000, 'k'), 1}, {"x\x1b[31m\xff", std::string(5000, 'v')}};
  const std::string key = refusal_of([&] { JsonObject(value, "x.json", "").finish(); });
  EXPECT_LT(key.size(), 400U);
  JsonObject object(value, "x.json", "");
  const std::string number = refusal_of([&] { object.number("x\x1b[31m\xff"); });
  EXPECT_LT(number.size(), 400U);
  EXPECT_NE(number.find("/x\ufffd[31m\ufffd: must be a number, got \"vvv"), std::string::npos);
}

TEST(RegularFile, AnythingElseIsRefusedAtOnce) {
  const TemporaryFolder folder("regular");
  std::ofstream(folder / "file") << "{}";
  fs::create_symlink(folder / "file", folder / "link");
  fs::create_symlink("/dev/zero", folder / "zeros");
  fs::create_symlink(folder / "loop", folder / "loop");
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  fs::create_symlink(folder / "fifo", folder / "to_fifo");
  const auto refused = [&](const fs::path& file) {
    const std::string what = refusal_of([&] { require_regular_file(file); });
    EXPECT_EQ(refusal_of([&] { read_json_file(file); }), what);  // and does not wait
    return what;
  };
  EXPECT_EQ(refused(folder / "file"), "");
  EXPECT_EQ(refused(folder / "link"), "");
  EXPECT_NE(refused(folder.path()).find(": is a directory; name a regular file"),
            std::string::npos);
  EXPECT_NE(refused(folder / "fifo").find(": is a FIFO"), std::string::npos);
  EXPECT_NE(refused(folder / "to_fifo").find(": is a FIFO"), std::string::npos);
  EXPECT_NE(refused(folder / "zeros").find(": is a device"), std::string::npos);
  EXPECT_NE(refused(folder / "absent").find(": cannot be opened: there is no such file"),
            std::string::npos);
  EXPECT_NE(refused(folder / "loop").find(": cannot be opened: "), std::string::npos);
}

}  // namespace
}  // namespace ertbench
