#include "solvers/front/quiet_reference.h"

#include <Eigen/QR>
#include <algorithm>

#include "solvers/nuisances.h"

namespace ertbench {
namespace {

constexpr double window_s = 1;
constexpr int least_of_window = 8;  ///< of a window
constexpr int least_quiet = 2;      ///< windows
/// Largest mean square of the rest over that of the noise of a window's mean. For 208 channels it
/// is six standard deviations of chi^2.
constexpr double most_rest = 1.6;
/// The reference is the mean of so many frames or more, whose noise is left, too.
constexpr double reference_frames = 16;
/// Responses are of first order: this share of what they explain may be left beside them.
constexpr double second_order = 0.01;

}  // namespace

QuietReference::QuietReference(const Sensor& sensor)
    : drift_(Eigen::RowVectorXd::Zero(sensor.channels())), sum_(drift_) {
  const Eigen::MatrixXd columns = Nuisances{.level = 1, .gradient = 1}.responses(sensor);
  responses_ = columns.householderQr().householderQ() *
               Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

void QuietReference::follow(Eigen::Ref<Eigen::RowVectorXd> change, double time_s) {
  change -= drift_;
  if (!change.allFinite()) {
    quiet_windows_ = 0;
    return;
  }
  if (frames_ == 0) begin_s_ = time_s;
  sum_ += change;
  squares_ += change.squaredNorm();
  ++frames_;
  if (time_s - begin_s_ < window_s || frames_ < least_of_window) return;
  end_window();
  sum_.setZero();
  squares_ = 0;
  frames_ = 0;
}

void QuietReference::end_window() {
  const Eigen::RowVectorXd mean = sum_ / frames_;
  const auto channels = static_cast<double>(mean.size());
  const double noise = (squares_ - frames_ * mean.squaredNorm()) / ((frames_ - 1) * channels);
  least_noise_ = least_noise_ > 0 ? std::min(least_noise_, noise) : noise;
  const Eigen::RowVectorXd along = mean * responses_ * responses_.transpose();
  const double allowed = channels * least_noise_ * (most_rest / frames_ + 1 / reference_frames) +
                         second_order * second_order * along.squaredNorm();
  quiet_windows_ = (mean - along).squaredNorm() <= allowed ? quiet_windows_ + 1 : 0;
  if (quiet_windows_ < least_quiet) return;
  drift_ += along;
  quiet_windows_ = 0;
}

}  // namespace ertbench
