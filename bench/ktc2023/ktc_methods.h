#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/ktc2023/instrument.h"
#include "bench/ktc2023/ktc_files.h"
#include "core/json.h"

namespace ertbench {

/// A target as the methods see it.
struct KtcFrame {
  Eigen::VectorXd change;   ///< [channels] V per mA, target less empty tank; 0 where missing
  Eigen::VectorXd present;  ///< [channels] 1, or 0 where missing
};

/// What does not depend on the frame: the calibrated instrument.
struct KtcSetting {
  const TankModel* tank = nullptr;
  const KtcPatterns* patterns = nullptr;
  KtcCalibration calibration;
  Eigen::SparseMatrix<double> channels;  ///< channel_operator, of which a row has six entries
};

/// An image of a method [256, 256], row 0 on top, and its own segmentation where it has one.
struct KtcImage {
  Eigen::MatrixXd change;  ///< of log conductivity, or a level set
  std::optional<ClassMap> classes;
};

/// Weighted least squares on those packed resistances that the frame's channels depend on: half of
/// |W (P r - change)|^2 has the gradient `normal` r - `side`.
struct KtcMisfit {
  std::vector<Eigen::Index> pairs;  ///< of the 528; at least one of their electrodes was driven
  Eigen::MatrixXd normal;           ///< [pairs, pairs]
  Eigen::VectorXd side;             ///< [pairs]

  /// A channel's error has the deviations `noise`, ohm, and `model_error` times its change.
  KtcMisfit(const KtcSetting& setting, const KtcFrame& frame, double noise, double model_error);
};

/// A method that has seen no measurement of a target.
class KtcMethod {
 public:
  virtual ~KtcMethod() = default;
  /// Computes what depends on the instrument and on the channels that are present. Called before
  /// `reconstruct`, and not part of a target's time.
  virtual void prepare(const KtcSetting&, const KtcFrame&) {}
  virtual KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const = 0;
};

/// Makes a method of an entry of "methods":
/// - "one-step-gn": Gauss–Newton's first step with a smooth prior (Matérn 3/2) on log conductivity;
///   "length_mm", "noise" ohm.
/// - "gauss-newton": the same, iterated; "spread" of the logarithm, "iterations".
/// - "tsvd": truncated singular value decomposition in the same smooth functions; "rank".
/// - "level-set": one smooth level set, Gaussian a priori, is conductive above 1 and resistive
///   below -1; Gauss–Newton while the transition is sharpened. Also "contrast", the log ratio.
/// - "lmmse": the linear estimate of least mean squared error of the classes -1, 0, 1 from
///   "scenes" simulated cylinders; for each frame from the moments of the channels it has.
/// - "registry": any "solver" of the registry, see registry_method; "image_grid", and "scenes" of
///   the training where it needs one.
/// "model_error" is that part of each change, beside "noise". Throws InputError.
std::unique_ptr<KtcMethod> ktc_method_from_json(JsonObject& object, const TankModel& tank);

/// A solver of the registry. Its frames are those of ideal amplifiers, by the resistances between
/// electrodes that explain all channels best. One that needs no training is fitted to the sensor of
/// the channels that are present: the independent drives with all measurements. Another is trained,
/// or loaded from its "checkpoint", once for all levels, for adjacent pairs (TrainingTanks); the
/// channels of electrodes that a level lacks read zero.
struct RegistryOptions {
  nlohmann::json solver;  ///< its entry
  std::string source;     ///< file of the experiment
  std::string path;       ///< of the entry in it
  int image_grid = 32;
  int scenes = 16000;  ///< of a training
  double noise;        ///< as of KtcMisfit
  double model_error;
};
std::unique_ptr<KtcMethod> registry_method(RegistryOptions options);

}  // namespace ertbench
