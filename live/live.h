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
  std::string why;  ///< the reason why it ended
};

/// Images a stream of frames until it ends, a signal (SIGINT, SIGTERM, SIGHUP) arrives or standard
/// output is closed. Writes a line of JSON for each answered frame,
///
///     {"frame", "time_s", "latency_us", "solver_us", "dropped", ... and the keys of answer_json}
///
/// and lines {"event": ...}: "begin", "background" (the reference is known), "damaged" (at most one
/// a second), "silence" and "resumed" (the sender's), "end". A frame's latency is the time from its
/// arrival to its answer, waiting included. One thread reads, the caller's thread images and the
/// page has its own threads. Throws InputError for unusable input, also if a device disappears; the
/// record is completed first.
LiveSummary run_live(const LiveOptions& options, SolverRegistry& registry);

}  // namespace ertbench
