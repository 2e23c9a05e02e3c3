#include "bench/ktc2023/instrument.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ertbench {

double KtcPatterns::amplitude(Eigen::Index channel) const {
  return currents.col(drive_of(channel)).maxCoeff();
}

bool KtcPatterns::uses_first(Eigen::Index channel, int electrodes) const {
  return !currents.col(drive_of(channel)).head(electrodes).isZero(0) ||
         !measurements.col(channel % measurements.cols()).head(electrodes).isZero(0);
}

Eigen::MatrixXd channel_operator(const KtcPatterns& patterns, const Eigen::VectorXd& gain,
                                 const Eigen::VectorXd& common_mode) {
  constexpr int n = TankModel::electrodes;
  Eigen::MatrixXd out(patterns.channels(), TankModel::pairs);
  for (Eigen::Index channel = 0; channel < out.rows(); ++channel) {
    const Eigen::Index m = channel % patterns.measurements.cols();
    const Eigen::VectorXd pair = patterns.measurements.col(m);
    const Eigen::VectorXd current = patterns.currents.col(patterns.drive_of(channel));
    Eigen::Index sink = 0;
    current.minCoeff(&sink);
    Eigen::VectorXd reading = (1 + gain[m]) * pair + common_mode[m] / 2 * pair.cwiseAbs();
    reading[sink] -= common_mode[m];
    const Eigen::MatrixXd product =
        reading * current.transpose() / std::max(patterns.amplitude(channel), 1e-9);
    const Eigen::MatrixXd both = product + product.transpose();
    Eigen::Index at = 0;
    for (int a = 0; a < n; ++a) {
      for (int b = a; b < n; ++b) out(channel, at++) = a == b ? product(a, a) : both(a, b);
    }
  }
  return out;
}

namespace {

/// What may differ from an ideal instrument while a reference is fitted.
struct Freedom {
  bool impedances, common_mode, gains;
};
constexpr Freedom steps[] = {{}, {true, false, false}, {true, true, false}, {true, true, true}};

/// Gauss–Newton on the reference. The unknowns are the logarithms of conductivity and impedances,
/// then common modes and gains.
class ReferenceFit {
 public:
  ReferenceFit(const TankModel& tank, const KtcPatterns& patterns, const Eigen::VectorXd& voltages)
      : tank_(tank), patterns_(patterns), measured_(voltages) {
    for (Eigen::Index c = 0; c < measured_.size(); ++c) {
      measured_[c] /= patterns.amplitude(c);
      if (!std::isfinite(measured_[c])) missing_.push_back(c);
    }
    measured_(missing_).setZero();
  }

  double run(const Freedom& freedom, KtcCalibration& fit) const {
    constexpr int iterations = 8;
    double left = 0;
    for (int i = 0; i <= iterations; ++i) {
      left = step(freedom, fit, i < iterations);
    }
    return left;
  }

 private:
  /// Returns what is unexplained before it.
  double step(const Freedom& freedom, KtcCalibration& fit, bool move) const {
    constexpr double error = 0.003;            // of the model, ohm
    constexpr double impedance_spread = 2;     // of the logarithm
    constexpr double impedance_before = 1e-5;  // S m^2, next to no contact impedance
    constexpr double common_mode_spread = 0.1;
    constexpr double gain_spread = 0.02;
    constexpr int n = TankModel::electrodes;
    const Eigen::Index pairs = patterns_.measurements.cols();
    const Eigen::VectorXd triangles =
        Eigen::VectorXd::Constant(std::ssize(tank_.triangles()), fit.conductivity);
    fit.empty = tank_.solve(triangles, fit.contact_impedance);
    const Eigen::VectorXd resistance = TankModel::packed(fit.empty.resistance);
    const Eigen::VectorXd ideal = Eigen::VectorXd::Zero(pairs);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(pairs);
    const Eigen::VectorXd difference = channel_operator(patterns_, ideal, ideal) * resistance;
    const Eigen::VectorXd mean = channel_operator(patterns_, ideal, ones) * resistance - difference;
    const Eigen::MatrixXd channels = channel_operator(patterns_, fit.gain, fit.common_mode);
    Eigen::VectorXd residual = measured_ - channels * resistance;
    residual(missing_).setZero();
    const double left = residual.norm() / measured_.norm();
    if (!move) return left;
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(residual.size(), 1 + n + 2 * pairs);
    jacobian.col(0) = -channels * resistance;
    jacobian.middleCols(1, n) =
        channels * tank_.impedance_sensitivity(fit.empty, fit.contact_impedance);
    for (Eigen::Index c = 0; c < residual.size(); ++c) {
      jacobian(c, 1 + n + c % pairs) = mean[c];
      jacobian(c, 1 + n + pairs + c % pairs) = difference[c];
    }
    jacobian(missing_, Eigen::all).setZero();
    constexpr double fixed = 1e-9;
    Eigen::VectorXd spread(jacobian.cols());
    spread << 1e3, Eigen::VectorXd::Constant(n, freedom.impedances ? impedance_spread : fixed),
        Eigen::VectorXd::Constant(pairs, freedom.common_mode ? common_mode_spread : fixed),
        Eigen::VectorXd::Constant(pairs, freedom.gains ? gain_spread : fixed);
    Eigen::VectorXd from_prior(jacobian.cols());
    from_prior << 0, (fit.contact_impedance.array() / impedance_before).log(), fit.common_mode,
        fit.gain;
    // In units of the spreads, so that what is fixed does not spoil the condition.
    jacobian = (jacobian * spread.asDiagonal()).eval() / error;
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    normal.diagonal().array() += 1;
    Eigen::VectorXd change = normal.llt().solve(jacobian.transpose() * residual / error -
                                                from_prior.cwiseQuotient(spread));
    change = change.cwiseProduct(spread).eval();
    fit.conductivity *= std::exp(change[0]);
    fit.contact_impedance.array() *= change.segment(1, n).array().min(1).max(-1).exp();
    fit.common_mode += change.segment(1 + n, pairs);
    fit.gain += change.tail(pairs);
    return left;
  }

  const TankModel& tank_;
  const KtcPatterns& patterns_;
  Eigen::VectorXd measured_;
  std::vector<Eigen::Index> missing_;
};

/// Difference of drives of the same two electrodes, `sign` 1: in the same direction, -1: reversed.
double between_drives(const KtcPatterns& patterns, const Eigen::VectorXd& voltages, int sign) {
  const Eigen::Index pairs = patterns.measurements.cols();
  double apart = 0;
  double all = 0;
  const auto of_drive = [&](Eigen::Index d) -> Eigen::VectorXd {
    return voltages.segment(d * pairs, pairs) / patterns.amplitude(d * pairs);
  };
  for (Eigen::Index d = 0; d < patterns.currents.cols(); ++d) {
    for (Eigen::Index e = 0; e < d; ++e) {
      const Eigen::VectorXd ours = patterns.currents.col(d).cwiseSign();
      if (ours != sign * patterns.currents.col(e).cwiseSign()) continue;
      const Eigen::VectorXd one = of_drive(d);
      const Eigen::VectorXd other = sign * of_drive(e);
      if (!(one + other).allFinite()) continue;
      apart += (one - other).squaredNorm() / 2;
      all += (one.squaredNorm() + other.squaredNorm()) / 2;
    }
  }
  return all > 0 ? std::sqrt(apart / all) : NAN;
}

}  // namespace

KtcCalibration calibrate_ktc(const TankModel& tank, const KtcPatterns& patterns,
                             const Eigen::VectorXd& voltages, const std::string& step) {
  KtcCalibration out;
  out.gain = out.common_mode = Eigen::VectorXd::Zero(patterns.measurements.cols());
  const ReferenceFit fit(tank, patterns, voltages);
  for (std::size_t i = 0; i == 0 || ktc_calibration_steps[i - 1] != step; ++i) {
    out.unexplained.push_back(fit.run(steps[i], out));
  }
  out.repeated = between_drives(patterns, voltages, 1);
  out.reversed = between_drives(patterns, voltages, -1);
  return out;
}

}  // namespace ertbench
