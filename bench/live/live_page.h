#pragma once

#include <string>

namespace ertbench {

/// The page that shows a stream: HTML with its style and its script in it, without anything from
/// elsewhere. It listens to `/events`.
const std::string& live_page();

}  // namespace ertbench
