#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/errors.h"
#include "core/files.h"

/// libhdf5 loses a few hundred bytes when it refuses some damaged files. A target is one source,
/// and includes this once.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }

/// What the fuzzing targets share. A target gives the bytes that libFuzzer makes up to one of the
/// program's readers; the process ends, and libFuzzer keeps the bytes, where a sanitizer finds
/// something, an exception leaves the target, or `require` does not hold.
namespace ertbench::fuzzing {

namespace fs = std::filesystem;

/// The folder of this process.
inline const fs::path& folder() {
  static const TemporaryFolder folder("fuzz");
  return folder.path();
}

/// The bytes as a file, the same one at every call with this name.
inline fs::path file_of(const std::uint8_t* bytes, std::size_t size, const std::string& name) {
  fs::path file = folder() / name;
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  return file;
}

inline void require(bool holds, const std::string& what, std::string_view text = {}) {
  if (holds) return;
  std::fprintf(stderr, "ERROR: %s\n%.*s\n", what.c_str(), static_cast<int>(text.size()),
               text.data());
  std::abort();
}

/// Whether the text is UTF-8, by the judgement of a library that is not ours.
inline bool is_utf8(std::string_view text) {
  try {
    static_cast<void>(nlohmann::json(text).dump());
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

/// Whether a terminal or a viewer would take a character for a command: those below U+0020 but for
/// the line's end, U+007F, and U+0080 to U+009F.
inline bool has_control(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if ((c < 0x20 && c != '\n') || c == 0x7f) return true;
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    if (c == 0xc2 && next >= 0x80 && next < 0xa0) return true;
  }
  return false;
}

inline void require_plain_text(std::string_view text, const std::string& what) {
  require(is_utf8(text), what + " is not UTF-8", text);
  require(!has_control(text), what + " holds control characters", text);
}

/// Whether `read` takes the input. It may refuse it by an InputError whose message begins with
/// `place` (and is made fit for a terminal where it is shown); any other exception is a finding.
template <typename Read>
bool accepted(const std::string& place, Read&& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    const std::string_view message = error.what();
    require(message.starts_with(place), "the message does not begin with " + place, message);
    return false;
  }
}

}  // namespace ertbench::fuzzing
