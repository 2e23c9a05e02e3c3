#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace ertbench {

/// Bytes of JSON that are read: the library takes up to 16 times as many of memory.
inline constexpr std::uint64_t most_json_bytes = std::uint64_t{64} << 20U;
/// Of a record of ours, which has a kilobyte for each frame.
inline constexpr std::uint64_t most_record_bytes = std::uint64_t{1} << 30U;
/// Arrays and objects within each other: the library walks through them by calling itself.
inline constexpr int most_json_levels = 64;

/// The only way from bytes to JSON. `source` names them in messages: a file, an attribute of one.
/// Throws InputError where they are too many or nested too deeply (found before anything is made of
/// them), where they are not JSON, with line and column, and where a key stands twice in an object.
nlohmann::json parse_json(std::string_view text, const std::string& source,
                          std::uint64_t most_bytes = most_json_bytes);

/// Throws the InputError of parse_json for too many bytes.
void require_json_size(std::uint64_t bytes, const std::string& source, std::uint64_t most_bytes);

/// The text of a value, compact or with so many spaces for each level. Never throws: bytes in
/// strings that are not UTF-8, as a plugin may have put there, become U+FFFD.
std::string json_text(const nlohmann::json& value, int indent = -1);

/// A value of the user's as a message shows it: its first 60 characters, printable.
std::string json_shown(const nlohmann::json& value);

/// The value with its strings and keys printable, of at most `most` characters each.
nlohmann::json printable_json(const nlohmann::json& value, std::size_t most = 200);

}  // namespace ertbench
