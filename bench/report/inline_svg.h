#pragma once

#include <string>

namespace ertbench {

/// The picture of an SVG file as it may stand in an HTML page beside others: without the XML
/// declaration, ids that something refers to begin with `prefix`, all others are left out, and
/// `name` is read out in its place. Throws std::invalid_argument where the text is not SVG or
/// refers to anything outside itself.
std::string inline_svg(const std::string& svg, const std::string& prefix, const std::string& name);

}  // namespace ertbench
