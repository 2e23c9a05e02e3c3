#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/ktc2023/instrument.h"
#include "bench/ktc2023/ktc_score.h"
#include "core/json.h"

namespace ertbench {

/// A target as the methods see it.
struct KtcFrame {
  Eigen::VectorXd change;   ///< [channels] V per mA, target less empty tank; 0 where missing
  Eigen::VectorXd present;  ///< [channels] 1, or 0 where missing
};

/// What does not depend on the frame: the calibrated instrument.
struct KtcSetting {
  const TankModel* tank;
  KtcCalibration calibration;
  Eigen::SparseMatrix<double> channels;  ///< channel_operator, of which a row has six entries
};

/// An image of a method [256, 256], row 0 on top, and its own segmentation where it has one.
struct KtcImage {
  Eigen::MatrixXd change;  ///< of log conductivity, or a level set
  std::optional<ClassMap> classes;
};

/// A method that was trained on nothing.
class KtcMethod {
 public:
  virtual ~KtcMethod() = default;
  virtual KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const = 0;
};

/// Makes a method of an entry of "methods":
/// - "one-step-gn": Gauss–Newton's first step with a smooth prior (Matérn 3/2) on log conductivity;
///   "length_mm", "noise" ohm.
/// - "tsvd": truncated singular value decomposition in the same smooth functions; "rank".
/// - "level-set": one smooth level set, Gaussian a priori, is conductive above 1 and resistive
///   below -1; Gauss–Newton while the transition is sharpened. Also "contrast", the log ratio.
/// "model_error" is that part of each change, beside "noise". Throws InputError.
std::unique_ptr<KtcMethod> ktc_method_from_json(JsonObject& object, const TankModel& tank);

}  // namespace ertbench
