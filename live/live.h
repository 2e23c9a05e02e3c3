#pragma once

#include "live/line_output.h"
#include "live/live_setup.h"
#include "live/live_state.h"

namespace ertbench {

/// How a stream went.
struct LiveSummary {
  LiveCounts counts;
  LatencyHistogram latency;  ///< from arrival to answer
  double seconds = 0;
  std::string why;  ///< it ended
};

/// Images a stream of frames until it ends, SIGINT, SIGTERM or SIGHUP comes, or nobody reads
/// standard output any more. Writes a line of JSON for each frame that was answered,
///
///     {"frame", "time_s", "latency_us", "solver_us", "dropped", ... as answer_json has it}
///
/// and lines {"event": ...}: "begin", "background" (the reference is known), "damaged" (at most one
/// a second), "silence" and "resumed" (of the sender), "end". A frame's latency is the time from
/// its arrival to its answer, that of waiting included. A thread reads, the caller's images, the
/// page has threads of its own. Throws InputError for what cannot be used, also where a device
/// disappears; the record is closed properly before.
LiveSummary run_live(const LiveOptions& options, SolverRegistry& registry);

}  // namespace ertbench
