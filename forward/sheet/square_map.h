#pragma once

#include <complex>
#include <vector>

#include "forward/sheet/sheet.h"

namespace ertbench {

/// The conformal map w = S(z) of the square [-1, 1] x [-1, 1] (z = x + i y) onto the unit disc.
///
/// div(sigma grad u) = 0 keeps its form under it, and on the disc the Neumann function is
/// elementary: N(w, v) = -(ln|w - v| + ln|1 - w conj(v)|) / 2 pi. S is the lemniscate sine of the
/// turned square, S(z) = sl(c z) with c = varpi / (2 sqrt 2) e^(-i pi / 4), which takes the corners
/// to 1, i, -1, -i. It is analytic beyond the border, so contacts may touch it.
class SquareMap {
 public:
  SquareMap();

  /// For z in the closed square; S to 1e-15. S' vanishes in the corners, where it is good to 1e-8.
  DiscPoint operator()(std::complex<double> z) const;

 private:
  std::vector<double> series_;  ///< of sl(t) / t in powers of t^4
};

}  // namespace ertbench
