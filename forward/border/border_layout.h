#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/border/border_points.h"

namespace ertbench {

/// The arcs of a scene with the points that resolution 1 takes on each.
struct BorderLayout {
  std::vector<ContactArc> arcs;
  std::vector<int> counts;
};

/// As many points as what lies next to each border demands: other borders, the mirror image of the
/// border in the edge of the sheet, an electrode, its own far side. A border that comes very close
/// to something is cut there, so that points gather at that place and not all round.
/// `electrodes` [2, L] on the unit circle.
enum class BorderCuts { where_close, none };
BorderLayout border_layout(const Sheet& sheet, const Eigen::Array2Xd& electrodes,
                           const Scene& scene, BorderCuts cuts = BorderCuts::where_close);

}  // namespace ertbench
