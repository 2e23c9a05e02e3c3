#pragma once

#include <sstream>

namespace ertbench {

/// A stream into a text that throws std::bad_alloc where memory runs out. The standard's own keeps
/// that to itself and goes on with less, so that a table or a figure would lack some of its parts.
class TextStream : public std::ostringstream {
 public:
  TextStream() { exceptions(std::ios::badbit); }
};

}  // namespace ertbench
