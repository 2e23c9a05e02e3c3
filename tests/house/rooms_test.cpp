// Holds the house to tests/house/rooms.txt: every source file lies in a room of that table, and
// includes only what its room may.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

using Rooms = std::map<std::string, std::set<std::string>>;  ///< what each may include

/// Reads the table. Throws std::runtime_error naming the line where a room stands twice, or may
/// include one that is not yet there, which would open a way back up.
Rooms read_rooms(std::istream& in, const std::string& source) {
  Rooms rooms;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    line = line.substr(0, line.find('#'));
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    std::string room;
    std::istringstream(line.substr(0, colon)) >> room;
    std::set<std::string> allowed = {room};
    std::istringstream below(line.substr(colon + 1));
    for (std::string one; below >> one;) {
      if (!rooms.contains(one)) {
        throw std::runtime_error(source + ":" + std::to_string(number) + ": \"" + one +
                                 "\" is no room above this line");
      }
      allowed.insert(rooms.at(one).begin(), rooms.at(one).end());
    }
    if (!rooms.emplace(room, allowed).second) {
      throw std::runtime_error(source + ":" + std::to_string(number) + ": \"" + room +
                               "\" stands twice");
    }
  }
  return rooms;
}

/// Lines of a source file that break the table: "bench/x/y.cpp:3: ...".
std::vector<std::string> offences(const Rooms& rooms, const std::string& file, std::istream& in) {
  std::vector<std::string> out;
  const std::string room = fs::path(file).parent_path().string();
  if (!rooms.contains(room)) return {file + ": \"" + room + "\" is no room of the table"};
  const std::string include = "#include \"";
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (!line.starts_with(include)) continue;
    const std::string included = line.substr(include.size(), line.rfind('"') - include.size());
    const std::string other = fs::path(included).parent_path().string();
    if (rooms.at(room).contains(other)) continue;
    out.push_back(file + ":" + std::to_string(number) + ": " + room + " may not include " +
                  included);
  }
  return out;
}

Rooms the_rooms() {
  const std::string table = std::string(ERTBENCH_SOURCE_DIR) + "/tests/house/rooms.txt";
  std::ifstream in(table);
  return read_rooms(in, table);
}

TEST(Rooms, IncludeOnlyWhatTheTableAllows) {
  const Rooms rooms = the_rooms();
  const fs::path root = ERTBENCH_SOURCE_DIR;
  int files = 0;
  for (const char* top :
       {"core", "forward", "solvers", "models", "frames", "limit", "live", "bench", "python"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      std::ifstream in(entry.path());
      for (const std::string& line :
           offences(rooms, fs::relative(entry.path(), root).string(), in)) {
        ADD_FAILURE() << line;
      }
    }
  }
  EXPECT_GT(files, 200);
}

TEST(Rooms, EachSaysAtItsDoorWhatItIs) {
  for (const auto& [room, allowed] : the_rooms()) {
    const fs::path note = fs::path(ERTBENCH_SOURCE_DIR) / room / "README.md";
    EXPECT_TRUE(fs::exists(note)) << note
                                  << ": a few lines on what the room is, what goes in and "
                                     "what comes out";
  }
}

TEST(Rooms, TheTestSeesAnIncludeThatGoesUp) {
  std::istringstream table("low:\nhigh: low  # above\n");
  const Rooms rooms = read_rooms(table, "rooms.txt");
  std::istringstream good("#include \"low/a.h\"\n#include <vector>\n");
  EXPECT_TRUE(offences(rooms, "high/b.h", good).empty());
  std::istringstream bad("#include \"low/c.h\"\n\n#include \"high/b.h\"\n");
  EXPECT_EQ(offences(rooms, "low/a.h", bad),
            std::vector<std::string>{"low/a.h:3: low may not include high/b.h"});
  std::istringstream nowhere("");
  EXPECT_EQ(offences(rooms, "cellar/a.h", nowhere).size(), 1U);
}

TEST(Rooms, TheTableHasNoCircle) {
  std::istringstream circle("a: b\nb: a\n");
  EXPECT_THROW(read_rooms(circle, "rooms.txt"), std::runtime_error);
  std::istringstream twice("a:\na:\n");
  EXPECT_THROW(read_rooms(twice, "rooms.txt"), std::runtime_error);
}

}  // namespace
