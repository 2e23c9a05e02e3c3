#pragma once

#include <vector>

#include "bench/record/result_row.h"
#include "bench/run/stage.h"
#include "bench/score/image_contacts.h"
#include "core/json.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

class DatasetFile;

/// All frames of one test set, scored.
struct ScoredFrames {
  ResultRow row;            ///< its metrics and its counts of frames
  JsonValue frames;         ///< as in the record: {metric: [values], "status", ..., "readings"}
  JsonValue figure_images;  ///< [figure scenes][pixels] S/m
};

/// Optional outputs for a set beside its metrics, and how contacts are read out of its images.
struct ScoreRequest {
  std::vector<int> figure_scenes;  ///< whose images are kept
  ContactRule rule;                ///< for a solver that has no ContactFinder
  ContactDistances distances;
  bool keep_contacts = false;   ///< what was read out of each image is kept (FrameReading)
  bool keep_explained = false;  ///< and what it explains of the change (ExplainedChange)
  bool judge_frames = false;    ///< frames that this sheet cannot give are flagged (FrameBounds)
};

/// Reconstructs the set and scores every frame. Frames that move are asked for as a stream, a new
/// one for each sequence, so that a solver may use the last one.
ScoredFrames score_set(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
                       const ScoreRequest& request);

/// Fits every solver (or takes it from the cache), reconstructs every test set and scores each
/// frame. Its results are the rows, the images of the figure and the logs of training.
std::unique_ptr<Stage> accuracy_stage();

}  // namespace ertbench
